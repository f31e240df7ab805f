#include "collab/recording/recording.h"

#include <cstring>
#include <fstream>

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "collab/simulated/network/simulated_session.h"
#include "tests/collab/recording/recorded_boxes.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using testing::Boxes;
using ::testing::HasSubstr;
using testing::HeaderOf;
using testing::NodeOf;
using testing::Record;
using testing::RecordAlone;
using testing::ReplayFile;

TEST(Recording, HeaderRoundTrips) {
  RecordingHeader header = HeaderOf(0xFEDCBA9876543210, 1);
  header.peer.own_only = true;
  const Result<RecordingHeader> read = ParseHeader(AsText(header));
  ASSERT_TRUE(read.has_value()) << read.error().what;
  EXPECT_EQ(AsText(*read), AsText(header));
  EXPECT_EQ(read->parameters, header.parameters);
  EXPECT_TRUE(read->peer.own_only);
  EXPECT_EQ(read->peer.id, header.peer.id);
  EXPECT_EQ(read->peer.capacity, header.peer.capacity);
  EXPECT_EQ(read->peer.query_price, header.peer.query_price);
  EXPECT_EQ(read->peer.X_BD.p, header.peer.X_BD.p);
  EXPECT_EQ(read->peer.X_BD.q.coeffs(), header.peer.X_BD.q.coeffs());
}

// Protocol 6 adds digests to what peers say; what a frame takes in is the same.
TEST(Recording, HeaderOfProtocolFiveHasNoDigest) {
  RecordingHeader header = HeaderOf(1, 1);
  const std::string six = R"("protocol":)" + std::to_string(kProtocol);
  const auto read_as = [&](const std::string& protocol) {
    std::string text = AsText(header);
    const std::size_t at = text.find(six);
    EXPECT_NE(at, std::string::npos) << text;
    return ParseHeader(text.replace(at, six.size(), R"("protocol":)" + protocol));
  };
  const Result<RecordingHeader> five = read_as("5");
  ASSERT_TRUE(five) << five.error().what;
  EXPECT_FALSE(five->scene_digest);
  header.scene_digest = {1, 2, 3};
  const Result<RecordingHeader> own = ParseHeader(AsText(header));
  ASSERT_TRUE(own) << own.error().what;
  EXPECT_EQ(own->scene_digest, header.scene_digest);
  std::string cut = AsText(header);
  cut.erase(cut.find("0102030000") + 2, 2);
  EXPECT_THAT(ParseHeader(cut).error().what, HasSubstr("expected 64 hexadecimal digits"));
}

// An earlier protocol has other messages, so it is of no interest what else the header lacks.
TEST(Recording, EarlierProtocolIsRefusedByVersion) {
  const Result<RecordingHeader> read =
      ParseHeader(R"({"program": "0.3", "protocol": 2, "name": "anna", "scene": "none"})");
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().what,
            "recorded with protocol 2, this program's is " + std::to_string(kProtocol));
}

TEST(Recording, KnowsPeersByTheirNames) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "named";
  RecordingHeader header;
  header.name = "anna";
  header.peer.id = 3;
  {
    auto recorder = *Recorder::Create(file, header);
    recorder->Named(7, "ben");
    recorder->Begin(1, 100);
    recorder->End(42);
    recorder->Named(9, std::string(100, 'x'));
    recorder->Named(7, "ben");
    const Result<std::uint64_t> frames = recorder->Close();
    ASSERT_TRUE(frames);
    EXPECT_EQ(*frames, 1U);
  }
  const std::map<PeerId, std::string> names{{3, "anna"}, {7, "ben"}, {9, std::string(64, 'x')}};
  EXPECT_EQ(NamesIn(file), names);
  auto reader = *RecordingReader::Open(file);
  const auto frame = reader.Next();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->state_hash, 42U);
  EXPECT_FALSE(reader.Next());
  EXPECT_FALSE(reader.torn() || reader.damaged());
}

TEST(Recording, TruncatedEndLosesOnlyTheLastFrames) {
  const ScratchFolder scratch;
  const auto model = Boxes();
  const fs::path whole = scratch.path() / "whole";
  RecordAlone(whole, model, 300);
  const auto size = static_cast<std::int64_t>(fs::file_size(whole));
  for (const std::int64_t cut : {1, 3, 7, 100, 1000}) {
    const fs::path torn = scratch.path() / ("torn" + std::to_string(cut));
    fs::copy_file(whole, torn);
    fs::resize_file(torn, static_cast<std::uintmax_t>(size - cut));
    const ReplayResult result = ReplayFile(torn, model);
    EXPECT_FALSE(result.first_different);
    EXPECT_GE(result.frames, 290);
    EXPECT_LT(result.frames, 300);
  }
}

/// Returns where each frame of a recording begins, and where the last one ends.
std::vector<std::size_t> FrameStarts(const std::string& bytes) {
  std::vector<std::size_t> starts;
  std::uint32_t length = 0;
  std::memcpy(&length, &bytes[kRecordingMagic.size()], sizeof length);
  for (std::size_t at = kRecordingMagic.size() + 4 + length; at < bytes.size(); at += 8 + length) {
    starts.push_back(at);
    std::memcpy(&length, &bytes[at], sizeof length);
  }
  starts.push_back(bytes.size());
  return starts;
}

// A crash leaves an end within a frame. Everything else is no end but a fault, wherever it is.
TEST(Recording, DamagedFrameDiffersFromATruncatedEnd) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "r";
  RecordAlone(file, Boxes(), 60);
  std::ifstream stream(file, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(stream), {}};
  const std::vector<std::size_t> starts = FrameStarts(whole);
  ASSERT_EQ(starts.size(), 61U);

  const auto read = [&](const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
    Result<RecordingReader> reader = RecordingReader::Open(file);
    EXPECT_TRUE(reader.has_value());
    std::size_t frames = 0;
    while (reader->Next()) ++frames;
    return std::tuple(frames, reader->torn(), reader->damaged(),
                      static_cast<std::size_t>(reader->unread_bytes()));
  };
  EXPECT_EQ(read(whole), std::tuple(60U, false, false, 0U));
  // every byte of a frame: its length, its checksum and its content
  const std::size_t from = starts[20];
  for (std::size_t at = from; at < starts[21]; ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x40);
    ASSERT_EQ(read(bytes), std::tuple(20U, false, true, whole.size() - from)) << at - from;
  }
  // each length that a torn end may have
  for (std::size_t end = starts[59]; end < starts[60]; ++end) {
    const bool torn = end > starts[59];
    ASSERT_EQ(read(whole.substr(0, end)), std::tuple(59U, torn, false, end - starts[59]));
  }
  // blocks that a power cut left empty
  EXPECT_EQ(read(whole + std::string(4096, '\0')), std::tuple(60U, false, true, 4096U));
}

TEST(Recording, OtherFilesAreRefused) {
  const ScratchFolder scratch;
  for (const char* text : {"", "tandem-recording 2\n", "something else altogether, and long"}) {
    const Result<RecordingReader> reader = RecordingReader::Open(scratch.Write("file", text));
    ASSERT_FALSE(reader.has_value());
    EXPECT_THAT(reader.error().what, HasSubstr("is not a recording"));
  }
}

TEST(Recording, IsReadableAfterKill9) {
  const ScratchFolder scratch;
  const auto model = Boxes();
  const fs::path file = scratch.path() / "r";
  int reported[2];
  ASSERT_EQ(pipe(reported), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const RecordingHeader header = HeaderOf(1, 1);
    const std::unique_ptr<Recorder> recorder = Record(file, header);
    SimulatedSession session;
    session.Add(NodeOf(model, header, recorder.get(), 0), 1);
    session.Add(NodeOf(model, HeaderOf(2, 1), nullptr, 1), 2);
    const auto empty = fs::file_size(file);
    for (bool stated = false;;) {
      session.Step();
      if (stated || fs::file_size(file) == empty) continue;
      stated = write(reported[1], "!", 1) == 1;
    }
  }
  char mark = 0;
  ASSERT_EQ(read(reported[0], &mark, 1), 1);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(reported[0]);
  close(reported[1]);
  const ReplayResult result = ReplayFile(file, model);
  EXPECT_FALSE(result.first_different);
  EXPECT_GT(result.frames, 0);
}

TEST(Recording, RecordingAllocatesNothingOnTheHapticThread) {
  const ScratchFolder scratch;
  const auto model = Boxes();
  const RecordingHeader header = HeaderOf(1, 1);
  const std::unique_ptr<Recorder> recorder = Record(scratch.path() / "r", header);
  SimulatedSession session;
  session.Add(NodeOf(model, header, recorder.get(), 0), 1);
  session.Add(NodeOf(model, HeaderOf(2, 1), nullptr, 1), 2);
  for (int i = 0; i < 500; ++i) session.Step();
  kHapticThread.Enter();
  std::int64_t now_ns = session.now_ns();
  const testing::AllocationCounter counter;
  for (int i = 0; i < 1000; ++i) session.node(0).HapticFrame(now_ns += 1'000'000);
  EXPECT_EQ(counter.count(), 0);
}

}  // namespace
}  // namespace tandem
