#include "collab/recording/replay.h"

#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "collab/simulated/network/simulated_session.h"
#include "tests/collab/recording/recorded_boxes.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using testing::Boxes;
using testing::DiffersWith;
using testing::HeaderOf;
using testing::NodeOf;
using testing::Record;
using testing::RecordAlone;
using testing::ReplayFile;

// Gains of one's own and a gate that is off are inputs too: without them the replay differs.
TEST(Replay, LabGainsAreReplayed) {
  const ScratchFolder scratch;
  const auto model = Boxes();
  RecordingHeader header = HeaderOf(1, 1);
  header.law = "constant";
  header.limits.constant_stiffness = 70;
  header.limits.constant_damping = 1.0 / 3.0;
  header.peer.experiments.energy_gate = false;
  RecordingHeader other = header;
  other.peer.id = 2;
  const std::unique_ptr<Recorder> recorder = Record(scratch.path() / "r", header);
  SimulatedSession session;
  session.Add(NodeOf(model, header, recorder.get(), 0), 1);
  session.Add(NodeOf(model, other, nullptr, 1), 2);
  for (int i = 0; i < 4000; ++i) session.Step();
  ASSERT_TRUE(recorder->Close().has_value());
  const ReplayResult result = ReplayFile(scratch.path() / "r", model);
  EXPECT_FALSE(result.first_different);
  EXPECT_EQ(result.frames, 4000);

  Result<RecordingReader> reader = RecordingReader::Open(scratch.path() / "r");
  ASSERT_TRUE(reader.has_value());
  RecordingHeader defaults = reader->header();
  EXPECT_FALSE(defaults.peer.experiments.energy_gate);
  defaults.limits = {};
  const Result<std::unique_ptr<Replay>> replay = Replay::Create(defaults, model);
  ASSERT_TRUE(replay.has_value());
  EXPECT_TRUE(RunAll(*reader, **replay).first_different.has_value());
}

// Two peers hold one part against the plate, a third has its own part beside it. One is killed and
// another comes in its place. TANDEM_REPLAY_SECONDS=300 is the long run.
TEST(Replay, ThreePeerSessionReplaysBitForBit) {
  const char* requested = std::getenv("TANDEM_REPLAY_SECONDS");
  const int frames = 1000 * (requested != nullptr ? std::atoi(requested) : 10);
  const ScratchFolder scratch;
  const auto model = Boxes();
  std::vector<std::unique_ptr<Recorder>> recorders;
  SimulatedSession session;
  int loaded = 0;
  for (const PeerId id : {1, 2, 3}) {
    const RecordingHeader header = HeaderOf(id, id == 3 ? 2 : 1);
    recorders.push_back(Record(scratch.path() / std::to_string(id), header));
    session.Add(NodeOf(model, header, recorders.back().get(), static_cast<double>(id)), id);
  }
  for (int i = 0; i < frames; ++i) {
    if (i == frames / 2) session.Kill(1);
    if (i == frames * 3 / 4) session.Add(NodeOf(model, HeaderOf(4, 1), nullptr, 4), 4);
    // hands let go and grasp again: what the user asks for is an input too
    SpscQueue<Command>& asks = session.node(i % 2 == 0 ? 2 : 1).peer().commands();
    const ObjectId object = i % 2 == 0 ? 2 : 1;
    if (i % 2500 >= 2000 && i % 2500 < 2002) asks.TryPush({Command::Kind::kRelease, object, 0});
    if (i % 2500 >= 2200 && i % 2500 < 2202) asks.TryPush({Command::Kind::kGrab, object, 0});
    session.Step();
    loaded += session.node(1).peer().report().pushing_points > 0 ? 1 : 0;
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

// nCapacity follows what frames take, so each frame has it as an input. With one value for all the
// replay differs.
TEST(Replay, PerFrameCapacityIsReplayed) {
  const ScratchFolder scratch;
  const auto model = Boxes();
  const fs::path file = scratch.path() / "r";
  const auto capacity_of = [](int frame) {
    return 40.0 + 1.0 / 3.0 * (frame % 1000);  // some of these hold the box back
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

// Force layer and displacement are ordered while hands press. Without the orders everything would
// differ.
TEST(Replay, ClearanceOrdersAreReplayed) {
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

TEST(Replay, ChangedInputIsNamedByItsFrame) {
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

}  // namespace
}  // namespace tandem
