#include <chrono>
#include <csignal>
#include <limits>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/stat.h>

#include "tests/collab/recording/crafted_recording.h"
#include "tests/collab/recording/recorded_boxes.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using testing::Boxes;
using testing::CraftedFrame;
using testing::Framed;
using ::testing::HasSubstr;
using testing::HeaderOf;
using testing::RecordingOf;
using testing::ReplayFile;

std::optional<RecordedFrame> Decoded(const CraftedFrame& frame) {
  return DecodeFrame(frame.Ended());
}

template <typename T>
bool IsTaken(FramePart part, const T& value) {
  return Decoded(CraftedFrame().Part(part, value)).has_value();
}

MembershipChange ChangeOf(std::uint32_t claims) {
  MembershipChange change;
  change.peer = 7;
  change.claim_count = claims;
  return change;
}

CouplingLinks LinksOf(std::uint32_t count) {
  CouplingLinks links;
  links.from = 7;
  links.count = count;
  return links;
}

ObjectState StateOf() {
  ObjectState state;
  state.peer = 7;
  return state;
}

TEST(HostileRecording, CountsBeyondTheirArraysAreRefused) {
  EXPECT_TRUE(IsTaken(FramePart::kMembership, ChangeOf(kMaxClaims)));
  EXPECT_TRUE(IsTaken(FramePart::kLinks, LinksOf(kMaxLinks)));
  MembershipChange believes = ChangeOf(0);
  believes.belief_count = kMaxClaims;
  EXPECT_TRUE(IsTaken(FramePart::kMembership, believes));
  for (const std::uint32_t count : {65U, 200'000U, 0xFFFFFFFFU}) {
    EXPECT_FALSE(IsTaken(FramePart::kMembership, ChangeOf(count)));
    believes.belief_count = count;
    EXPECT_FALSE(IsTaken(FramePart::kMembership, believes));
    EXPECT_FALSE(IsTaken(FramePart::kLinks, LinksOf(count)));
  }
}

TEST(HostileRecording, UnknownKindsAreRefused) {
  MembershipChange change = ChangeOf(0);
  change.kind = static_cast<MembershipChange::Kind>(6);
  EXPECT_FALSE(IsTaken(FramePart::kMembership, change));
  Event event;
  event.peer = 7;
  EXPECT_TRUE(IsTaken(FramePart::kEvent, event));
  event.kind = static_cast<EventKind>(6);
  EXPECT_FALSE(IsTaken(FramePart::kEvent, event));
  Command command;
  EXPECT_TRUE(IsTaken(FramePart::kCommand, command));
  command.kind = static_cast<Command::Kind>(9);
  EXPECT_FALSE(IsTaken(FramePart::kCommand, command));
}

TEST(HostileRecording, ImplausibleNumbersAreRefused) {
  EXPECT_TRUE(IsTaken(FramePart::kState, StateOf()));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {nan, 1e300, -std::numeric_limits<double>::infinity()}) {
    ObjectState state = StateOf();
    state.X_WB.p.y() = bad;
    EXPECT_FALSE(IsTaken(FramePart::kState, state)) << bad;
    state = StateOf();
    state.X_WB.q.w() = bad;
    EXPECT_FALSE(IsTaken(FramePart::kState, state)) << bad;
    state = StateOf();
    state.V_WB.v.z() = bad;
    EXPECT_FALSE(IsTaken(FramePart::kState, state)) << bad;
    CouplingLinks links = LinksOf(1);
    links.entries[0].stiffness = bad;
    EXPECT_FALSE(IsTaken(FramePart::kLinks, links)) << bad;
  }
  Anchor device;
  device.X_WA.p.x() = nan;
  EXPECT_FALSE(IsTaken(FramePart::kDevice, device));
  EXPECT_FALSE(Decoded(CraftedFrame(-1)));
  EXPECT_FALSE(Decoded(CraftedFrame(std::numeric_limits<std::int64_t>::max())));
}

// 300 changes, 1,100 events and 100 orders in a frame must not end the program by its own checks.
TEST(HostileRecording, RecordsBeyondThePeersQueuesAreRefused) {
  const auto of = [](FramePart part, const auto& value, int count) {
    CraftedFrame frame;
    for (int i = 0; i < count; ++i) frame.Part(part, value);
    return Decoded(frame).has_value();
  };
  Event event;
  event.peer = 7;
  EXPECT_TRUE(of(FramePart::kMembership, ChangeOf(0), 256));
  EXPECT_FALSE(of(FramePart::kMembership, ChangeOf(0), 257));
  EXPECT_TRUE(of(FramePart::kEvent, event, 1024));
  EXPECT_FALSE(of(FramePart::kEvent, event, 1025));
  EXPECT_TRUE(of(FramePart::kCommand, Command{}, 64));
  EXPECT_FALSE(of(FramePart::kCommand, Command{}, 65));
  EXPECT_FALSE(of(FramePart::kLinks, LinksOf(0), (1 << 16) + 1));
}

TEST(HostileRecording, FrameStartsAndEndsOnce) {
  CraftedFrame twice;
  twice(FramePart::kBegin);
  twice(std::int64_t{5});
  twice(1e5);
  EXPECT_FALSE(Decoded(twice));
  EXPECT_FALSE(DecodeFrame(CraftedFrame().Ended() + CraftedFrame().Ended()));
  EXPECT_FALSE(DecodeFrame(std::string()));
}

// A peer with much held back by its network takes more states at once than the queues of another.
TEST(HostileRecording, SamplesOfAStalledPeerAreReplayed) {
  const ScratchFolder scratch;
  CraftedFrame frame;
  for (int i = 0; i < 20'000; ++i) {
    ObjectState state = StateOf();
    state.object = static_cast<ObjectId>(i);
    frame.Part(FramePart::kState, state).Part(FramePart::kLinks, LinksOf(0));
  }
  const fs::path file =
      scratch.Write("r", RecordingOf(AsText(HeaderOf(1, 1)), Framed(frame.Ended())));
  EXPECT_EQ(ReplayFile(file, Boxes()).first_different, 0);  // its hash belongs to no state
}

TEST(HostileRecording, OrdersOfAnySizeAreHarmless) {
  const ScratchFolder scratch;
  CraftedFrame frame;
  for (const auto kind : {Command::Kind::kLayer, Command::Kind::kDisplace, Command::Kind::kGrab,
                          Command::Kind::kGive, Command::Kind::kHeal, Command::Kind::kStop}) {
    Command command{kind, 0xFFFFFFF0, 9, std::numeric_limits<std::int32_t>::min(), -1e300};
    frame.Part(FramePart::kCommand, command);
    command = {kind, 1, 9, std::numeric_limits<std::int32_t>::max(), 1e300};
    frame.Part(FramePart::kCommand, command);
  }
  std::string frames = Framed(frame.Ended());
  for (int i = 2; i < 300; ++i) frames += Framed(CraftedFrame(i * 1'000'000).Ended());
  const fs::path file = scratch.Write("r", RecordingOf(AsText(HeaderOf(1, 1)), frames));
  Result<RecordingReader> reader = RecordingReader::Open(file);
  ASSERT_TRUE(reader);
  auto replay = *Replay::Create(reader->header(), Boxes());
  int done = 0;
  while (const auto next = reader->Next()) {
    replay->Run(*next);
    ++done;
  }
  EXPECT_EQ(done, 299);
}

// No fault in a header is believed. A force layer of -5 would end the program.
TEST(HostileRecording, HeaderIsValidatedAsAScene) {
  const ordered_json good = ordered_json::parse(AsText(HeaderOf(1, 1)));
  ASSERT_TRUE(ParseHeader(good.dump()));
  const std::vector<std::pair<const char*, ordered_json>> bad{{"force_layer", -5},
                                                              {"force_layer", 1e9},
                                                              {"voxel_size", 0},
                                                              {"voxel_size", nullptr},
                                                              {"contact_model", 2},
                                                              {"friction", -1},
                                                              {"friction", 1e300},
                                                              {"friction", "much"},
                                                              {"held_object", -2},
                                                              {"grasp", {0, 0, 0, 0, 0, 0, 0}},
                                                              {"grasp", {0, 0, 0, 1, 0, 0, 1e300}},
                                                              {"grasp", {0, 0, 0}},
                                                              {"settle_ns", -1},
                                                              {"wait_for", 1'000'000},
                                                              {"capacity", -1},
                                                              {"capacity", nullptr},
                                                              {"look_price", -1},
                                                              {"law_limits", 7},
                                                              {"name", std::string(1000, 'x')},
                                                              {"name", "anna\x1b[31m"},
                                                              {"name", 4},
                                                              {"scene", "a\nb"},
                                                              {"program", "\x1b]0;title\x07"},
                                                              {"peer", -1},
                                                              {"device", {{"stiffness", -1}}}};
  for (const auto& [key, value] : bad) {
    ordered_json json = good;
    json[key] = value;
    if (std::string(key) == "law_limits") json[key] = {{"stiffness", -1}};
    const Result<RecordingHeader> header = ParseHeader(json.dump());
    ASSERT_FALSE(header) << key << " " << value;
    EXPECT_THAT(header.error().what, HasSubstr(std::string("its header: ") + key));
  }
  for (const std::string& text :
       {std::string(), std::string("null"), std::string("[]"), std::string(100'000, '['),
        R"({"protocol":)" + std::string(100'000, '[')}) {
    EXPECT_FALSE(ParseHeader(text));
  }
}

TEST(HostileRecording, NamesArePrintedAsPlainText) {
  const ScratchFolder scratch;
  std::string content(1, static_cast<char>(FramePart::kName));
  content += std::string("\x07\0\0\0\0\0\0\0", 8);
  std::string name = "ben\x1b[2J\xff";
  name.resize(kNameBytes, '\0');
  const fs::path file =
      scratch.Write("r", RecordingOf(AsText(HeaderOf(1, 1)), Framed(content + name)));
  EXPECT_EQ(NamesIn(file).at(7), "ben?[2J?");
}

// A frame seems to begin at every byte. To sum up all that follows each would take hours for 16
// MiB.
TEST(HostileRecording, TruncatedEndIsDetectedQuickly) {
  const ScratchFolder scratch;
  std::string end;
  const std::uint32_t beyond = 1U << 24U;
  end.append(reinterpret_cast<const char*>(&beyond), 4).append(4, '\0');
  std::string lure(1 << 20, '\x01');
  for (std::size_t i = 0; i + 4 < lure.size(); i += 9) {
    // lengths that end at a byte which says that a frame ends there
    const std::uint32_t length = 1 << 19;
    std::memcpy(&lure[i], &length, 4);
  }
  for (std::size_t i = 8; i < lure.size(); i += 9) lure[i] = static_cast<char>(FramePart::kEnd);
  for (int i = 0; i < 12; ++i) end += lure;
  const fs::path file = scratch.Write("r", RecordingOf(AsText(HeaderOf(1, 1)), end));
  const auto before = std::chrono::steady_clock::now();
  auto reader = *RecordingReader::Open(file);
  EXPECT_FALSE(reader.Next());
  EXPECT_TRUE(reader.torn() || reader.damaged());
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(5));
}

TEST(HostileRecording, OnlyRegularFilesAreOpened) {
  const ScratchFolder scratch;
  const fs::path pipe = scratch.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const auto reader = RecordingReader::Open(pipe);
  ASSERT_FALSE(reader);
  EXPECT_THAT(reader.error().what, HasSubstr("it is not a regular file"));
}

// ---- The recorder, on bad disks and beside others. ----

TEST(Recorder, FileBelongsToOnePeer) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "r";
  const auto first = *Recorder::Create(file, HeaderOf(1, 1));
  const auto second = Recorder::Create(file, HeaderOf(2, 1));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().what,
            file.string() + " exists already: recordings are never overwritten");
  struct stat status {};
  ASSERT_EQ(stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
}

TEST(Recorder, FirstRecorderClaimsAnEmptyFile) {
  const ScratchFolder scratch;
  const fs::path file = scratch.Write("r", "");
  const auto first = Recorder::Create(file, HeaderOf(1, 1));
  EXPECT_TRUE(first);
  EXPECT_FALSE(Recorder::Create(file, HeaderOf(2, 1)));
  (*first)->Discard();
  EXPECT_FALSE(fs::exists(file));
}

void PutFrames(Recorder& recorder, int frames) {
  for (int i = 0; i < frames; ++i) {
    recorder.Begin(1'000'000 * i, 1e5);
    recorder.OnDevice(Anchor{});
    recorder.End(static_cast<std::uint64_t>(i));
  }
}

// The recorder tells the number of frames that are there, not of those that were put in.
TEST(Recorder, FullDiskIsReportedAtOnce) {
  const ScratchFolder scratch;
  const fs::path file = scratch.path() / "r";
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit full{20'000, before.rlim_max};
  const auto recorder = *Recorder::Create(file, HeaderOf(1, 1));
  setrlimit(RLIMIT_FSIZE, &full);
  PutFrames(*recorder, 500);
  std::string news;
  for (int i = 0; i < 500 && news.empty(); ++i) {
    usleep(10'000);
    news = recorder->News();
  }
  PutFrames(*recorder, 500);
  EXPECT_EQ(recorder->News(), "");  // once
  const Result<std::uint64_t> closed = recorder->Close();
  setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_FALSE(closed);
  auto reader = *RecordingReader::Open(file);
  int there = 0;
  while (reader.Next()) ++there;
  EXPECT_FALSE(reader.torn() || reader.damaged());
  EXPECT_GT(there, 50);
  EXPECT_LT(there, 500);
  EXPECT_EQ(closed.error().what, file.string() +
                                     ": cannot be written: File too large; it ends after " +
                                     std::to_string(there) + " frames");
  EXPECT_EQ(news, closed.error().what);
}

}  // namespace
}  // namespace tandem
