#include "collab/recording/recording.h"

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <tuple>

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "collab/recording/recorder.h"
#include "collab/recording/replay.h"
#include "collab/simulated/simulated_session.h"
#include "engine/haptics/scripted_device.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// A shared box on a plate, and a box of one's own beside it.
std::shared_ptr<const WorldModel> Boxes() {
  const auto box_at = [](double x) {
    return Transformed(testing::Box(Vec3(0.03, 0.02, 0.02)), {Quat::Identity(), Vec3(x, 0, 0)});
  };
  const TriangleMesh plate =
      Transformed(testing::Box(Vec3(0.2, 0.2, 0.01)), {Quat::Identity(), Vec3(0, 0, -0.03)});
  auto model = std::make_shared<WorldModel>(
      *testing::MakeWorldModel({{plate, true}, {box_at(0)}, {box_at(0.07)}}, 0.002));
  model->scene.bodies[1].shared = true;
  return model;
}

// To and fro, down into the plate and turned, for ever.
HandScript Kneading(double phase) {
  HandScript script;
  for (int i = 0; i <= 1200; ++i) {
    const double t = 0.25 * i;
    script.waypoints.push_back({t, Vec3(0.03 * std::sin(t + phase), 0.01 * std::cos(2 * t), -0.02),
                                RotationBy(Vec3(0, 0, 0.3 * std::sin(3 * t + phase)))});
  }
  return script;
}

RecordingHeader HeaderOf(PeerId id, int object) {
  RecordingHeader header;
  header.program = "test";
  header.name = "peer " + std::to_string(id);
  header.scene = "none";
  header.scene_hash = 42;
  header.parameters = {
      .voxel_size = 0.002, .contact = ContactModel::kPlain, .force_layer = 3, .friction = 0.25};
  header.law = "p+d";
  header.peer.id = id;
  header.peer.held_object = object;
  header.peer.settle_ns = 123'456'789;
  header.peer.wait_for = 1;
  header.peer.capacity = 12345.678901234567;
  header.peer.look_price = 98.765432109876543;
  header.peer.X_BD = {RotationBy(Vec3(0.1, 0.2, 0.3)), Vec3(0.001, -0.002, 1.0 / 3.0 * 0.01)};
  return header;
}

std::unique_ptr<PeerNode> Node(const std::shared_ptr<const WorldModel>& model,
                               const RecordingHeader& header, FrameTap* tap, double phase) {
  NodeOptions options;
  options.peer = header.peer;
  options.peer.coupling.law = *MakeLaw(header.law, header.limits, true);
  options.peer.tap = tap;
  options.name = header.name;
  options.conditions = {.delay_ms = 40, .jitter_ms = 20, .loss = 0.05};
  HandScript script = Kneading(phase);
  script.X_BD = header.peer.X_BD;
  const auto body = static_cast<std::size_t>(
      model->body_index[static_cast<std::size_t>(header.peer.held_object)]);
  return std::make_unique<PeerNode>(
      model, std::make_unique<ScriptedDevice>(script, model->bodies[body].X_WB0), 42, options);
}

std::unique_ptr<Recorder> Record(const fs::path& file, const RecordingHeader& header) {
  Result<std::unique_ptr<Recorder>> recorder = Recorder::Create(file, header);
  EXPECT_TRUE(recorder.has_value()) << recorder.error().what;
  return *std::move(recorder);
}

ReplayResult ReplayFile(const fs::path& file, const std::shared_ptr<const WorldModel>& model) {
  Result<RecordingReader> reader = RecordingReader::Open(file);
  EXPECT_TRUE(reader.has_value()) << reader.error().what;
  Result<std::unique_ptr<Replay>> replay = Replay::Create(reader->header(), model);
  EXPECT_TRUE(replay.has_value()) << replay.error().what;
  return RunAll(*reader, **replay);
}

// One peer's recording of a session of two, so many frames long; `before` each frame its peer is
// asked something.
void RecordAlone(const fs::path& file, const std::shared_ptr<const WorldModel>& model, int frames,
                 const std::function<void(Peer&, int)>& before = {}) {
  const RecordingHeader header = HeaderOf(1, 1);
  const std::unique_ptr<Recorder> recorder = Record(file, header);
  SimulatedSession session;
  session.Add(Node(model, header, recorder.get(), 0), 1);
  session.Add(Node(model, HeaderOf(2, 1), nullptr, 1), 2);
  for (int i = 0; i < frames; ++i) {
    if (before) before(session.node(0).peer(), i);
    session.Step();
  }
  ASSERT_TRUE(recorder->Close().has_value());
}

// Whether a replay differs anywhere from its recording once each frame is altered.
bool DiffersWith(const fs::path& file, const std::shared_ptr<const WorldModel>& model,
                 const std::function<void(RecordedFrame&, int)>& alter) {
  Result<RecordingReader> reader = RecordingReader::Open(file);
  EXPECT_TRUE(reader.has_value());
  Result<std::unique_ptr<Replay>> replay = Replay::Create(reader->header(), model);
  EXPECT_TRUE(replay.has_value());
  bool differs = false;
  for (int i = 0; std::optional<RecordedFrame> frame = reader->Next(); ++i) {
    alter(*frame, i);
    differs = (*replay)->Run(*frame) != frame->state_hash || differs;
  }
  return differs;
}

// Gains of one's own and a gate that is off are inputs too: replayed without them it differs.
TEST(Recording, ALabsGainsAreRepeated) {
  const ScratchFolder scratch;
  const auto model = Boxes();
  RecordingHeader header = HeaderOf(1, 1);
  header.law = "constant";
  header.limits.constant_stiffness = 70;
  header.limits.constant_damping = 1.0 / 3.0;
  header.peer.coupling.gate = false;
  RecordingHeader other = header;
  other.peer.id = 2;
  const std::unique_ptr<Recorder> recorder = Record(scratch.path() / "r", header);
  SimulatedSession session;
  session.Add(Node(model, header, recorder.get(), 0), 1);
  session.Add(Node(model, other, nullptr, 1), 2);
  for (int i = 0; i < 4000; ++i) session.Step();
  ASSERT_TRUE(recorder->Close().has_value());
  const ReplayResult result = ReplayFile(scratch.path() / "r", model);
  EXPECT_FALSE(result.first_different);
  EXPECT_EQ(result.frames, 4000);

  Result<RecordingReader> reader = RecordingReader::Open(scratch.path() / "r");
  ASSERT_TRUE(reader.has_value());
  RecordingHeader defaults = reader->header();
  EXPECT_FALSE(defaults.peer.coupling.gate);
  defaults.limits = {};
  const Result<std::unique_ptr<Replay>> replay = Replay::Create(defaults, model);
  ASSERT_TRUE(replay.has_value());
  EXPECT_TRUE(RunAll(*reader, **replay).first_different.has_value());
}

// Two hold one part against the plate, a third its own part beside it; one is killed and another
// comes in its place. TANDEM_REPLAY_SECONDS=300 is the long run.
TEST(Recording, ThreePeersSessionIsRepeatedBitForBit) {
  const char* asked = std::getenv("TANDEM_REPLAY_SECONDS");
  const int frames = 1000 * (asked != nullptr ? std::atoi(asked) : 10);
  const ScratchFolder scratch;
  const auto model = Boxes();
  std::vector<std::unique_ptr<Recorder>> recorders;
  SimulatedSession session;
  int loaded = 0;
  for (const PeerId id : {1, 2, 3}) {
    const RecordingHeader header = HeaderOf(id, id == 3 ? 2 : 1);
    recorders.push_back(Record(scratch.path() / std::to_string(id), header));
    session.Add(Node(model, header, recorders.back().get(), static_cast<double>(id)), id);
  }
  for (int i = 0; i < frames; ++i) {
    if (i == frames / 2) session.Kill(1);
    if (i == frames * 3 / 4) session.Add(Node(model, HeaderOf(4, 1), nullptr, 4), 4);
    // hands let go and grasp again: what the user asks for is an input too
    SpscQueue<Command>& asks = session.node(i % 2 == 0 ? 2 : 1).peer().commands();
    const ObjectId object = i % 2 == 0 ? 2 : 1;
    if (i % 2500 >= 2000 && i % 2500 < 2002) asks.TryPush({Command::Kind::kRelease, object, 0});
    if (i % 2500 >= 2200 && i % 2500 < 2202) asks.TryPush({Command::Kind::kGrab, object, 0});
    session.Step();
    loaded += session.node(1).peer().report().loaded_points > 0 ? 1 : 0;
  }
  EXPECT_GT(loaded, frames / 4) << "there was contact";
  const std::array<std::int64_t, 3> expected{frames, frames / 2, frames};
  for (std::size_t p = 0; p < 3; ++p) {
    const Result<std::uint64_t> recorded = recorders[p]->Close();
    ASSERT_TRUE(recorded.has_value()) << recorded.error().what;
    const ReplayResult result = ReplayFile(scratch.path() / std::to_string(p + 1), model);
    EXPECT_FALSE(result.first_different)
        << "peer " << p + 1 << ", frame " << *result.first_different;
    EXPECT_EQ(result.frames, expected[p]);
  }
}

// nCapacity follows what frames take, so it is an input of each: with one for all it differs.
TEST(Recording, ACapacityOfItsOwnForEachFrameIsRepeated) {
  const ScratchFolder scratch;
  const auto model = Boxes();
  const fs::path file = scratch.path() / "r";
  const auto capacity_of = [](int frame) {
    return 40.0 + 1.0 / 3.0 * (frame % 1000);  // some of which hold the box back
  };
  RecordAlone(file, model, 4000, [&](Peer& peer, int frame) {
    peer.SetCapacity(capacity_of(frame));
  });
  const ReplayResult result = ReplayFile(file, model);
  EXPECT_FALSE(result.first_different);
  EXPECT_EQ(result.frames, 4000);
  EXPECT_TRUE(DiffersWith(file, model, [&](RecordedFrame& frame, int number) {
    EXPECT_EQ(frame.capacity, capacity_of(number));
    frame.capacity = HeaderOf(1, 1).peer.capacity;
  }));
}

// Force layer and displacement are ordered while hands press; without them all would be different.
TEST(Recording, OrdersOfClearanceAreRepeated) {
  const ScratchFolder scratch;
  const auto model = Boxes();
  const fs::path file = scratch.path() / "r";
  RecordAlone(file, model, 4000, [](Peer& peer, int frame) {
    SpscQueue<Command>& asks = peer.commands();
    if (frame == 1000) {
      asks.TryPush({.kind = Command::Kind::kDisplace, .metres = -1.0 / 3.0 * 0.002});
    }
    if (frame == 2000) asks.TryPush({.kind = Command::Kind::kLayer, .layer = 4});
  });
  const ReplayResult result = ReplayFile(file, model);
  EXPECT_FALSE(result.first_different);
  EXPECT_EQ(result.frames, 4000);

  std::vector<Command> orders;
  EXPECT_TRUE(DiffersWith(file, model, [&](RecordedFrame& frame, int) {
    orders.insert(orders.end(), frame.commands.begin(), frame.commands.end());
    frame.commands.clear();
  }));
  ASSERT_EQ(orders.size(), 2U);
  EXPECT_EQ(orders[0].metres, -1.0 / 3.0 * 0.002);
  EXPECT_EQ(orders[1].layer, 4);
}

TEST(Recording, TheHeaderSurvivesAsItWas) {
  RecordingHeader header = HeaderOf(0xFEDCBA9876543210, 1);
  header.peer.own_only = true;
  const Result<RecordingHeader> read = ParseHeader(AsText(header));
  ASSERT_TRUE(read.has_value()) << read.error().what;
  EXPECT_EQ(AsText(*read), AsText(header));
  EXPECT_EQ(read->parameters, header.parameters);
  EXPECT_TRUE(read->peer.own_only);
  EXPECT_EQ(read->peer.id, header.peer.id);
  EXPECT_EQ(read->peer.capacity, header.peer.capacity);
  EXPECT_EQ(read->peer.look_price, header.peer.look_price);
  EXPECT_EQ(read->peer.X_BD.p, header.peer.X_BD.p);
  EXPECT_EQ(read->peer.X_BD.q.coeffs(), header.peer.X_BD.q.coeffs());
}

// Messages were other ones then: what else its header lacks is of no interest.
TEST(Recording, OneOfAnEarlierProtocolIsRefusedByThat) {
  const Result<RecordingHeader> read =
      ParseHeader(R"({"program": "0.3", "protocol": 2, "name": "anna", "scene": "none"})");
  ASSERT_FALSE(read.has_value());
  EXPECT_EQ(read.error().what,
            "recorded with protocol 2, this program's is " + std::to_string(kProtocol));
}

TEST(Recording, AnotherInputIsNamedByItsFrame) {
  const ScratchFolder scratch;
  const auto model = Boxes();
  const fs::path file = scratch.path() / "r";
  RecordAlone(file, model, 1500);
  Result<RecordingReader> reader = RecordingReader::Open(file);
  ASSERT_TRUE(reader.has_value());
  Result<std::unique_ptr<Replay>> replay = Replay::Create(reader->header(), model);
  ASSERT_TRUE(replay.has_value());
  std::optional<std::int64_t> first;
  for (std::int64_t number = 0; std::optional<RecordedFrame> frame = reader->Next(); ++number) {
    // the smallest change that a number can have
    double& x = frame->device.X_WA.p.x();
    if (number == 1234) x = std::nextafter(x + 1e-9, 1.0);
    const bool same = (*replay)->Run(*frame) == frame->state_hash;
    if (!same && !first) first = number;
  }
  EXPECT_EQ(first, 1234);
}

TEST(Recording, ATornEndCostsTheLastFramesOnly) {
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

/// Where each frame of a recording begins, and where the last one ends.
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

// What a crash leaves ends within a frame; all else is no end but a fault, wherever it is.
TEST(Recording, ADamagedFrameIsToldFromATornEnd) {
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

TEST(Recording, AFileThatIsNoRecordingIsRefused) {
  const ScratchFolder scratch;
  for (const char* text : {"", "tandem-recording 1\n", "something else altogether, and long"}) {
    const Result<RecordingReader> reader = RecordingReader::Open(scratch.Write("file", text));
    ASSERT_FALSE(reader.has_value());
    EXPECT_THAT(reader.error().what, HasSubstr("is not a recording"));
  }
}

TEST(Recording, IsReadableAfterKill9) {
  const ScratchFolder scratch;
  const auto model = Boxes();
  const fs::path file = scratch.path() / "r";
  int told[2];
  ASSERT_EQ(pipe(told), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const RecordingHeader header = HeaderOf(1, 1);
    const std::unique_ptr<Recorder> recorder = Record(file, header);
    SimulatedSession session;
    session.Add(Node(model, header, recorder.get(), 0), 1);
    session.Add(Node(model, HeaderOf(2, 1), nullptr, 1), 2);
    const auto empty = fs::file_size(file);
    for (bool said = false;;) {
      session.Step();
      if (said || fs::file_size(file) == empty) continue;
      said = write(told[1], "!", 1) == 1;
    }
  }
  char mark = 0;
  ASSERT_EQ(read(told[0], &mark, 1), 1);
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  close(told[0]);
  close(told[1]);
  const ReplayResult result = ReplayFile(file, model);
  EXPECT_FALSE(result.first_different);
  EXPECT_GT(result.frames, 0);
}

TEST(Recording, CostsTheHapticThreadNoAllocation) {
  const ScratchFolder scratch;
  const auto model = Boxes();
  const RecordingHeader header = HeaderOf(1, 1);
  const std::unique_ptr<Recorder> recorder = Record(scratch.path() / "r", header);
  SimulatedSession session;
  session.Add(Node(model, header, recorder.get(), 0), 1);
  session.Add(Node(model, HeaderOf(2, 1), nullptr, 1), 2);
  for (int i = 0; i < 500; ++i) session.Step();
  kHapticThread.Enter();
  std::int64_t now_ns = session.now_ns();
  const testing::AllocationCounter counter;
  for (int i = 0; i < 1000; ++i) session.node(0).HapticFrame(now_ns += 1'000'000);
  EXPECT_EQ(counter.count(), 0);
}

}  // namespace
}  // namespace tandem
