#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "collab/coupling/coupling_law.h"
#include "collab/recording/recorder.h"
#include "collab/recording/replay.h"
#include "collab/simulated/network/simulated_session.h"
#include "engine/base/units.h"
#include "engine/haptics/scripted_device.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

// A wall of 4 mm comes between two instances of one shared cube (paper §6.1;
// docs/decisions/0023-apart.md). The wall stands in the plane x = 0 from y = -200 to y = 0. All
// instances begin above its edge.
namespace tandem {
namespace {

using testing::At;
using testing::Box;

// m; side of the cube: on both sides of the wall its instances are 20 mm apart, for which 500 N/m
// take 10 N, within the 12 N of a device
constexpr double kSide = 0.014;
constexpr double kWall = 0.004;   // m
constexpr double kAbove = 0.03;   // m, of the start over the wall's edge
constexpr double kVoxel = 0.002;  // m

const std::shared_ptr<const WorldModel>& WallAndCube() {
  static const std::shared_ptr<const WorldModel> kModel = [] {
    const TriangleMesh wall = At(Box(Vec3(kWall, 0.2, 0.1)), Vec3(0, -0.1, 0));
    const TriangleMesh cube = At(Box(Vec3(kSide, kSide, kSide)), Vec3(0, kAbove, 0));
    auto model =
        std::make_shared<WorldModel>(*testing::MakeWorldModel({{wall, true}, {cube}}, kVoxel));
    model->scene.bodies[1].shared = true;
    model->scene.bodies[1].name = "cube";
    return model;
  }();
  return kModel;
}

/// Returns a hand that goes aside by so much, then down along that side of the wall.
HandScript Side(double aside, double hand_stiffness) {
  HandScript script;
  script.impedance.stiffness = hand_stiffness;
  const Quat q = Quat::Identity();
  script.waypoints = {{0, Vec3::Zero(), q},
                      {1, Vec3::Zero(), q},
                      {1.6, Vec3(aside, 0, 0), q},
                      {2.4, Vec3(aside, -0.12, 0), q}};
  return script;
}

/// A hand that remembers what it was given.
class RecordingDevice : public Device {
 public:
  RecordingDevice(const HandScript& script, const Pose& X_WB0) : hand_(script, X_WB0) {}
  void Start() noexcept override { hand_.Start(); }
  Anchor Read() noexcept override { return hand_.Read(); }
  void Render(const Wrench& F_D_W) noexcept override {
    step = (F_D_W.f - force).norm();
    force = F_D_W.f;
    hand_.Render(F_D_W);
  }
  Vec3 force = Vec3::Zero();
  double step = 0;  // N, since the frame before

 private:
  ScriptedDevice hand_;
};

struct ApartCase {
  std::vector<PeerId> ids;         // ids of the users
  std::vector<double> aside;       // place of each beside the wall's plane
  double delay_ms = 20;            // one way
  double hand_stiffness = 300;     // N/m
  std::filesystem::path record{};  // folder of recordings, a file each; empty: none
};

struct ApartRun {
  explicit ApartRun(const ApartCase& test) {
    const auto& model = WallAndCube();
    for (std::size_t user = 0; user < test.ids.size(); ++user) {
      NodeOptions options;
      options.peer.id = test.ids[user];
      options.peer.held_object = 1;
      options.peer.wait_for = test.ids.size() - 1;
      options.name = std::to_string(test.ids[user]);
      options.conditions.delay_ms = test.delay_ms;
      if (!test.record.empty()) options.peer.observer = Record(test.record / options.name, options);
      auto device = std::make_unique<RecordingDevice>(Side(test.aside[user], test.hand_stiffness),
                                                      model->bodies[0].X_WB0);
      devices.push_back(device.get());
      session.Add(std::make_unique<PeerNode>(model, std::move(device), 42, options),
                  test.ids[user]);
    }
    while (!session.node(0).peer().started_ns()) session.Step();
    most_step.resize(session.size());
    found_s.resize(session.size(), -1);
  }

  FrameObserver* Record(const std::filesystem::path& file, const NodeOptions& options) {
    auto recorder = Recorder::Create(file, {.program = "test",
                                            .name = options.name,
                                            .scene = "none",
                                            .scene_hash = 42,
                                            .parameters = ParametersOf(WallAndCube()->scene),
                                            .law = DefaultLaw()->name(),
                                            .limits = {},
                                            .peer = options.peer});
    EXPECT_TRUE(recorder.has_value());
    recorders.push_back(*std::move(recorder));
    return recorders.back().get();
  }

  const Peer& peer(std::size_t user) { return session.node(user).peer(); }
  Vec3 place(std::size_t user) { return peer(user).held_state()->X_WB.p; }
  double apart() {
    double most = 0;
    for (std::size_t a = 0; a < session.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) most = std::max(most, (place(a) - place(b)).norm());
    }
    return most;
  }
  double LinkForce(std::size_t user) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t link = 0; link < peer(user).shared()->coupled(); ++link) {
      sum += peer(user).report().links_B_W[link].f;
    }
    return sum.norm();
  }

  void Run(double seconds) {
    for (int i = 0; i < static_cast<int>(1000 * seconds); ++i) {
      session.Step();
      time_s += 1e-3;
      for (std::size_t user = 0; user < session.size(); ++user) {
        if (!session.present(user)) continue;
        most_step[user] = std::max(most_step[user], devices[user]->step);
        if (found_s[user] < 0 && peer(user).separation().trapped()) found_s[user] = time_s;
        for (const std::string& line : session.node(user).TakeNotifications()) {
          news.push_back(std::to_string(user) + ": " + line);
        }
        // below the edge no cube may be nearer to the wall than its contact lets it
        const Vec3 p = place(user);
        if (p.y() < -0.5 * kSide) {
          deepest = std::max(deepest, 0.5 * (kSide + kWall) - std::abs(p.x()));
        }
      }
    }
  }
  bool Told(const std::string& part) const {
    return std::any_of(news.begin(), news.end(), [&part](const std::string& line) {
      return line.find(part) != std::string::npos;
    });
  }

  std::vector<std::unique_ptr<Recorder>> recorders;
  SimulatedSession session;
  std::vector<RecordingDevice*> devices;
  std::vector<double> most_step;  // N from one frame to the next, on each hand
  std::vector<double> found_s;    // -1: not
  std::vector<std::string> news;
  double deepest = -1;  // m into the wall
  double time_s = 0;    // since the hands began
};

// Both sides find the wall about 0.6 s after the two no longer come nearer. The gentle slew caps
// the link. After two seconds more the second comes back to the first by its way. This holds for
// both ends and any delay.
TEST(Apart, WallBetweenInstancesIsDetectedForceCappedAndResolved) {
  for (const double delay_ms : {1.0, 20.0, 100.0, 200.0}) {
    SCOPED_TRACE(std::to_string(delay_ms) + " ms");
    ApartRun run({{1, 2}, {0.06, -0.06}, delay_ms});
    run.Run(2.4);
    const double apart = run.apart();
    EXPECT_GT(apart, kSide);

    double capped_s = -1;
    double led_s = -1;
    double back_s = -1;
    for (int i = 0; i < 1000; ++i) {
      run.Run(0.01);
      const bool led = run.peer(1).separation().guiding();
      const bool capped = run.LinkForce(0) <= 3.01 && run.LinkForce(1) <= 3.01;
      if (capped_s < 0 && run.found_s[1] > 0 && capped) capped_s = run.time_s;
      if (led_s < 0 && led) led_s = run.time_s;
      if (back_s < 0 && led_s > 0 && !led) back_s = run.time_s;
      if (led) {
        EXPECT_EQ(run.devices[1]->force, Vec3::Zero());
        // pictures, traces and exports show this of it
        EXPECT_EQ(run.peer(1).report().hand_B_W.f, Vec3::Zero());
        EXPECT_EQ(run.peer(1).report().hand_B_W.tau, Vec3::Zero());
      }
    }

    // both find the wall: the hands part for good at 1.6 to 2.4 s
    for (const double found_s : run.found_s) EXPECT_NEAR(found_s, 2.8, 0.5);
    // the link is capped before the way back begins
    EXPECT_LT(capped_s - run.found_s[1], ToSeconds(InstanceSeparation::kPatienceNs));

    // the second comes back by its way: patience and letting go, looked at every 10 ms; the search
    // takes some frames
    EXPECT_NEAR(led_s - run.found_s[1], 2.2, 0.02);
    EXPECT_LT(back_s - led_s, 4.0);
    EXPECT_LT(run.apart(), 0.02);
    EXPECT_FALSE(run.peer(0).separation().apart());
    EXPECT_FALSE(run.peer(1).separation().apart());

    // neither a hand nor the wall feels it
    EXPECT_LT(run.deepest, 0.5 * kVoxel);
    for (std::size_t user = 0; user < 2; ++user) {
      EXPECT_LT(run.most_step[user], 1.0);
      EXPECT_EQ(run.peer(user).guard().guarded(), 0U);  // nothing was left for it to do
    }

    // both users hear of it
    for (const char* part :
         {"0: something stands between", "1: something stands between", "1: your cube",
          "0: nothing stands between", "1: nothing stands between"}) {
      EXPECT_TRUE(run.Told(part)) << part;
    }
    EXPECT_FALSE(run.Told("0: your cube"));  // the lower id stays where it is

    const std::string key = "delay_" + std::to_string(static_cast<int>(delay_ms)) + "_ms";
    RecordProperty(key + "_found_first_s", std::to_string(run.found_s[0]));
    RecordProperty(key + "_found_second_s", std::to_string(run.found_s[1]));
    RecordProperty(key + "_capped_s", std::to_string(capped_s));
    RecordProperty(key + "_led_s", std::to_string(led_s));
    RecordProperty(key + "_back_s", std::to_string(back_s));
    RecordProperty(key + "_apart_before_mm", std::to_string(1e3 * apart));
    RecordProperty(key + "_apart_after_mm", std::to_string(1e3 * run.apart()));
    RecordProperty(key + "_force_step_N",
                   std::to_string(std::max(run.most_step[0], run.most_step[1])));
  }
}

// A peer that is parted from the lowest comes to it: two to one, or one to two.
TEST(Apart, ThreePeersMeetAtTheLowestPeersInstance) {
  for (const std::size_t lonely : {0U, 1U, 2U}) {
    SCOPED_TRACE(lonely);
    ApartCase test{{1, 2, 3}, {-0.06, -0.06, -0.06}, 50};
    test.aside[lonely] = 0.06;
    ApartRun run(test);
    run.Run(2.4);
    EXPECT_GT(run.apart(), kSide);
    run.Run(10);
    EXPECT_LT(run.apart(), 0.02);
    EXPECT_GT(run.place(0).x() * test.aside[0], 0);  // on its side
    EXPECT_LT(run.deepest, 0.5 * kVoxel);
    for (std::size_t user = 0; user < 3; ++user) {
      EXPECT_FALSE(run.peer(user).separation().trapped());
      EXPECT_LT(run.most_step[user], 1.0);
    }
  }
}

// Either of the two asks: the second comes back at once, without the time of patience.
TEST(Apart, UserCanRequestTheWayBack) {
  for (const std::size_t asks : {0U, 1U}) {
    ApartRun run({{1, 2}, {0.06, -0.06}, 50});
    run.Run(2.6);
    ASSERT_TRUE(run.peer(asks).separation().apart());
    ASSERT_FALSE(run.peer(1).separation().guiding());
    ASSERT_TRUE(
        run.session.node(asks).peer().commands().TryPush({Command::Kind::kHeal, kNoObject, 0}));
    run.Run(0.3);
    EXPECT_TRUE(run.peer(1).separation().guiding());
    run.Run(5);
    EXPECT_LT(run.apart(), 0.02);
  }
}

// The user asks before the link is capped. It pulls with more than is gentle to let go of in 0.2 s,
// and falls with the hand all the same, at both ends.
TEST(Apart, LinkForceFallsWithTheReleasingHand) {
  for (const double delay_ms : {1.0, 50.0}) {
    SCOPED_TRACE(delay_ms);
    ApartRun run({{1, 2}, {0.06, -0.06}, delay_ms});
    const auto apart = [&run] {
      return run.peer(1).separation().apart() && run.LinkForce(1) > 4;
    };
    for (int i = 0; i < 3000 && !apart(); ++i) run.Run(0.001);
    ASSERT_TRUE(apart());
    ASSERT_TRUE(
        run.session.node(1).peer().commands().TryPush({Command::Kind::kHeal, kNoObject, 0}));
    run.Run(0.02);
    ASSERT_TRUE(run.Told("1: "));
    for (int i = 0; i < 300 && !run.peer(1).separation().guiding(); ++i) run.Run(0.001);
    ASSERT_TRUE(run.peer(1).separation().guiding());
    EXPECT_LT(run.LinkForce(1), 0.1);
    run.Run(1e-3 * delay_ms + 0.1);
    EXPECT_LT(run.LinkForce(0), 0.1);
    run.Run(5);
    EXPECT_LT(run.apart(), 0.02);
    for (const double step : run.most_step) EXPECT_LT(step, 1.0);
  }
}

TEST(Apart, SaysWhenNothingSeparatesTheInstances) {
  ApartRun run({{1, 2}, {0.06, 0.06}, 20});
  run.Run(2);
  run.session.node(0).peer().commands().TryPush({Command::Kind::kHeal, kNoObject, 0});
  run.Run(0.1);
  EXPECT_TRUE(run.Told("0: heal: nothing stands between your body"));
  EXPECT_FALSE(run.peer(1).separation().guiding());
}

// All of it is in the inputs of the frames, and no frame of it allocates.
TEST(Apart, WayBackReplaysBitForBit) {
  const ScratchFolder scratch;
  ApartRun run({{1, 2}, {0.06, -0.06}, 30, 300, scratch.path()});
  run.Run(3);
  run.session.node(0).peer().commands().TryPush({Command::Kind::kHeal, kNoObject, 0});
  run.Run(0.5);
  EXPECT_TRUE(run.peer(1).separation().guiding());
  run.Run(4);
  EXPECT_LT(run.apart(), 0.02);
  for (const std::size_t user : {0U, 1U}) {
    ASSERT_TRUE(run.recorders[user]->Close().has_value());
    Result<RecordingReader> reader =
        RecordingReader::Open(scratch.path() / std::to_string(user + 1));
    ASSERT_TRUE(reader.has_value()) << reader.error().what;
    Result<std::unique_ptr<Replay>> replay = Replay::Create(reader->header(), WallAndCube());
    ASSERT_TRUE(replay.has_value()) << replay.error().what;
    int frames = 0;
    int different = 0;
    while (const std::optional<RecordedFrame> frame = reader->Next()) {
      const testing::AllocationCounter allocations;
      different += (*replay)->Run(*frame) != frame->state_hash ? 1 : 0;
      EXPECT_EQ(allocations.count(), 0) << frames;
      ++frames;
    }
    EXPECT_EQ(different, 0);
    EXPECT_GT(frames, 7500);
  }
}

// The hands are too soft to leave one another: the coupling holds them together, and no alarm is
// heard.
TEST(Apart, SoftHandsAreHeldTogether) {
  ApartRun run({{1, 2}, {0.06, -0.06}, 20, 15});
  run.Run(8);
  EXPECT_LT(run.apart(), 0.02);
  EXPECT_FALSE(run.Told("something stands between"));
}

// The other vanishes while we are on the way: the hand takes the body where it is, softly.
TEST(Apart, WayBackEndsWhenThePartnerVanishes) {
  ApartRun run({{1, 2}, {0.06, -0.06}, 20});
  run.Run(2.6);
  run.session.node(1).peer().commands().TryPush({Command::Kind::kHeal, kNoObject, 0});
  run.Run(1);
  ASSERT_TRUE(run.peer(1).separation().guiding());
  run.session.Kill(0);
  run.Run(3);
  EXPECT_FALSE(run.peer(1).separation().guiding());
  EXPECT_TRUE(run.Told("1: no way is known"));
  EXPECT_LT(run.most_step[1], 1.0);
  EXPECT_LT(run.devices[1]->force.norm(), 1.0);
}

}  // namespace
}  // namespace tandem
