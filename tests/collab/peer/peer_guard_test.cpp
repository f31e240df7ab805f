// Tests that nothing reaches a hand but through the guard, by whole peers whose devices see all
// that they are given.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "collab/simulated/network/simulated_session.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

/// A handle that is thrown about, and now and then says nonsense. It keeps the worst that it was
/// given.
class WildDevice : public Device {
 public:
  void Start() noexcept override {}
  Anchor Read() noexcept override {
    const int frame = frames_++;
    if (frame < 300) return {};
    Anchor anchor;
    switch (frame / 50 % 4) {
      case 0:
        anchor.X_WA.p = Vec3(frame % 2 == 0 ? 3.0 : -3.0, 0, 0);
        return anchor;
      case 1:
        anchor.X_WA.q = RotationBy(Vec3(0, 0.05 * frame, 0));
        anchor.V_WA.v = Vec3(0, 0, 500);
        return anchor;
      case 2:
        anchor.X_WA.p.y() = frame % 3 == 0 ? std::numeric_limits<double>::quiet_NaN() : 1e200;
        return anchor;
      default:
        // finite, and yet beyond what a body can be moved by
        if (frame % 5 == 0) anchor.V_WA.v.x() = -5e303;
        if (frame % 5 == 1) anchor.V_WA.w.x() = 1e200;
        return anchor;
    }
  }
  void Render(const Wrench& F_D_W) noexcept override {
    sound = sound && F_D_W.f.allFinite() && F_D_W.tau.allFinite();
    force = std::max(force, F_D_W.f.norm());
    moment = std::max(moment, F_D_W.tau.norm());
    step = std::max(step, (F_D_W.f - last_.f).norm());
    turn = std::max(turn, (F_D_W.tau - last_.tau).norm());
    last_ = F_D_W;
  }
  DeviceCapabilities capabilities() const noexcept override {
    DeviceCapabilities can;
    can.peak = {.force = 8, .moment = 0.3};
    return can;
  }

  bool sound = true;
  double force = 0, moment = 0, step = 0, turn = 0;

 private:
  int frames_ = 0;
  Wrench last_;
};

TEST(PeerGuard, NoMotionExceedsTheForceLimits) {
  const TriangleMesh box = testing::Box(Vec3(0.03, 0.02, 0.02));
  auto model = std::make_shared<WorldModel>(*testing::MakeWorldModel({{box}}, 0.001));
  model->scene.bodies[0].shared = true;
  SimulatedSession session;
  std::array<WildDevice*, 2> devices{};
  for (PeerId id = 1; id <= 2; ++id) {
    NodeOptions options;
    options.peer.id = id;
    options.peer.held_object = 0;
    options.conditions.delay_ms = 20;
    auto device = std::make_unique<WildDevice>();
    devices[id - 1] = device.get();
    session.Add(std::make_unique<PeerNode>(model, std::move(device), 42, options), id);
  }
  for (int i = 0; i < 3000; ++i) session.Step();
  for (std::size_t p = 0; p < 2; ++p) {
    const WildDevice& device = *devices[p];
    EXPECT_TRUE(device.sound);
    EXPECT_NEAR(device.force, 8, 1e-9);  // it was thrown as hard as that
    EXPECT_NEAR(device.moment, 0.3, 1e-9);
    EXPECT_LE(device.step, ForceGuard::kForceStep + 1e-9);
    EXPECT_LE(device.turn, ForceGuard::kMomentStep + 1e-9);
    const ForceGuard& guard = session.node(p).peer().guard();
    EXPECT_GT(guard.guarded(), 500U);
    EXPECT_EQ(guard.frames(), 3000U);
    EXPECT_TRUE(session.node(p).peer().held_state()->X_WB.p.allFinite());
  }
}

/// A handle whose state the test sets.
class SettableDevice : public Device {
 public:
  void Start() noexcept override {}
  Anchor Read() noexcept override { return now; }
  void Render(const Wrench& F_D_W) noexcept override { felt = F_D_W; }
  void Stop() noexcept override { ++stops; }
  bool failed() const noexcept override { return in_trouble; }
  bool stop_button() const noexcept override { return pressed; }
  DeviceCapabilities capabilities() const noexcept override {
    DeviceCapabilities can;
    can.freedoms_out = motors;
    return can;
  }

  int motors = 6;
  Anchor now;
  Wrench felt;
  int stops = 0;
  bool in_trouble = false;
  bool pressed = false;
};

/// A session of a peer with such a handle, which holds nothing at first, and a peer that watches.
struct GuardedSession {
  explicit GuardedSession(int motors = 6) {
    const TriangleMesh box = testing::Box(Vec3(0.03, 0.02, 0.02));
    model = std::make_shared<WorldModel>(*testing::MakeWorldModel({{box}}, 0.001));
    for (PeerId id = 1; id <= 2; ++id) {
      NodeOptions options;
      options.peer.id = id;
      options.conditions.delay_ms = 20;
      auto held_by = std::make_unique<SettableDevice>();
      held_by->motors = motors;
      if (id == 1) device = held_by.get();
      session.Add(std::make_unique<PeerNode>(model, std::move(held_by), 42, options), id);
    }
  }
  void Run(int frames) {
    for (int i = 0; i < frames; ++i) {
      session.Step();
      largest = std::max({largest, device->felt.f.norm(), device->felt.tau.norm()});
      const StepReport& report = peer().report();
      sound = sound && report.contact_B_W.f.allFinite() && report.hand_B_W.f.allFinite();
      for (std::size_t node = 0; node < 2; ++node) {
        sound = sound && Sound(session.node(node).world().state(0).X_WB);
      }
      for (const std::string& line : session.node(0).TakeNotifications())
        notification.push_back(line);
    }
  }
  static bool Sound(const Pose& pose) { return pose.p.allFinite() && pose.q.coeffs().allFinite(); }
  void Order(Command::Kind kind) {
    ASSERT_TRUE(session.node(0).peer().commands().TryPush({kind, 0, 0}));
  }
  Peer& peer() { return session.node(0).peer(); }
  Vec3 place(std::size_t node) { return session.node(node).world().state(0).X_WB.p; }

  std::shared_ptr<WorldModel> model;
  SimulatedSession session;
  SettableDevice* device = nullptr;
  double largest = 0;  // N or N m; largest that the hand felt
  bool sound = true;   // all poses, and forces that are told to others
  std::vector<std::string> notification;
};

// The device begins with nonsense. The hand grasps once its place is known, and feels nothing of
// the nonsense.
TEST(PeerGuard, NoGraspBeforeTheFirstHandPose) {
  GuardedSession run;
  run.device->now.X_WA.p.x() = std::numeric_limits<double>::quiet_NaN();
  run.Order(Command::Kind::kGrab);
  run.Run(300);
  ASSERT_EQ(run.peer().ownership().held(), 0);
  const Vec3 before = run.place(0);
  run.device->now.X_WA.p = Vec3(0.008, 0.02, 0);
  run.Run(500);
  EXPECT_LT(run.largest, 1e-9);
  EXPECT_LT((run.place(0) - before).norm(), 1e-9);
  run.device->now.X_WA.p.y() += 0.003;
  run.Run(4000);  // held beside its middle it turns first, and slowly back
  EXPECT_NEAR(run.place(0).y() - before.y(), 0.003, 1e-4) << "now it holds it";
}

// In one frame the simulation leaves the numbers. The body stays where it was, for all. The hand
// feels nothing of it and is told so, and when it takes the body again it feels it again.
TEST(PeerGuard, BodySurvivesANonFiniteFrame) {
  GuardedSession run;
  run.Order(Command::Kind::kGrab);
  run.Run(300);
  ASSERT_EQ(run.peer().ownership().held(), 0);
  run.model->scene.gravity_W.x() = std::numeric_limits<double>::infinity();
  run.Run(1);
  run.model->scene.gravity_W = Vec3::Zero();
  EXPECT_EQ(run.place(0), Vec3::Zero());
  run.device->now = {};
  run.device->now.X_WA.p.y() = 0.005;
  run.Run(5);
  run.largest = 0;
  run.Run(500);
  EXPECT_EQ(run.largest, 0.0);
  EXPECT_EQ(run.peer().report().hand_B_W.f.norm(), 0.0) << "what others are told is what it feels";
  EXPECT_EQ(run.peer().report().hand_B_W.tau.norm(), 0.0);
  EXPECT_TRUE(run.sound);
  EXPECT_TRUE(run.peer().guard().broken());
  const auto reported =
      std::count_if(run.notification.begin(), run.notification.end(), [](const std::string& line) {
        return line.find("is not a number") != std::string::npos;
      });
  EXPECT_EQ(reported, 1);
  run.Order(Command::Kind::kRelease);
  run.Run(300);
  run.Order(Command::Kind::kGrab);
  run.Run(300);
  ASSERT_EQ(run.peer().ownership().held(), 0);
  EXPECT_FALSE(run.peer().guard().broken());
  run.device->now.X_WA.p.y() += 0.005;
  run.Run(3);
  EXPECT_GT(run.largest, 0.1);
  run.Run(1000);
  EXPECT_NEAR(run.place(0).y(), 0.010, 1e-3);
  EXPECT_NEAR(run.place(1).y(), 0.010, 1e-3);
}

// The hand takes nothing, neither by its own user's order nor by another's gift.
TEST(PeerGuard, StoppedHandReleasesAndGrabsNothingUntilResumed) {
  GuardedSession run;
  run.Order(Command::Kind::kGrab);
  run.Run(300);
  ASSERT_EQ(run.peer().ownership().held(), 0);
  run.Order(Command::Kind::kStop);
  run.Run(10);
  EXPECT_EQ(run.peer().ownership().held(), -1);
  run.Order(Command::Kind::kGrab);
  run.Run(300);
  EXPECT_EQ(run.peer().ownership().held(), -1);
  EXPECT_EQ(run.peer().ownership().wanted(), -1);
  // the other takes it and hands it over
  Peer& other = run.session.node(1).peer();
  ASSERT_TRUE(other.commands().TryPush({Command::Kind::kGrab, 0, 0}));
  run.Run(300);
  ASSERT_EQ(other.ownership().held(), 0);
  ASSERT_TRUE(other.commands().TryPush({Command::Kind::kGive, kNoObject, 1}));
  run.Run(300);
  EXPECT_EQ(other.ownership().held(), -1);
  EXPECT_EQ(run.peer().ownership().held(), -1) << "it is put down, not taken";
  run.Order(Command::Kind::kResume);
  run.Order(Command::Kind::kGrab);
  run.Run(300);
  EXPECT_EQ(run.peer().ownership().held(), 0);
}

/// A device with limits, mapped by a scale that may change.
class MappedDevice : public SettableDevice {
 public:
  void Rescale(double to) noexcept override { scale = to; }
  DeviceCapabilities capabilities() const noexcept override {
    DeviceCapabilities can;
    can.stiffness = 400 / scale;
    return can;
  }
  double scale = 1;
};

// The handle makes a small step, and the force is that of the first frame, before the part has
// moved.
TEST(PeerGuard, RescaledDeviceKeepsItsStiffnessLimit) {
  const TriangleMesh box = testing::Box(Vec3(0.03, 0.02, 0.02));
  const auto model = testing::MakeWorldModel({{box}}, 0.001);
  NodeOptions options;
  options.peer.id = 1;
  options.peer.held_object = 0;
  auto made = std::make_unique<MappedDevice>();
  MappedDevice& device = *made;
  SimulatedSession session;
  session.Add(std::make_unique<PeerNode>(model, std::move(made), 42, options), 1);
  for (int i = 0; i < 500; ++i) session.Step();
  ASSERT_TRUE(session.node(0).peer().attached());
  const auto felt_after = [&](double scale) {
    const Command rescale{.kind = Command::Kind::kScale, .metres = scale};
    EXPECT_TRUE(session.node(0).peer().commands().TryPush(rescale));
    for (int i = 0; i < 4000; ++i) session.Step();
    device.now.X_WA.p.x() += 1e-3;
    session.Step();
    return session.node(0).peer().report().hand_B_W.f.norm() / 1e-3;
  };
  const double first = felt_after(1);
  const double scaled = felt_after(8);
  EXPECT_GT(first, 300);
  EXPECT_LE(first, 400 * 1.01);
  EXPECT_GT(scaled, 30);
  EXPECT_LE(scaled, 50 * 1.01);
}

// A device in the peer's own process has no guard but the peer's. Its button and its trouble end
// the force, until somebody resumes with both gone.
TEST(PeerGuard, StopButtonAndFaultEndTheForceUntilResumed) {
  for (const bool button : {true, false}) {
    GuardedSession run;
    bool& cause = button ? run.device->pressed : run.device->in_trouble;
    run.Order(Command::Kind::kGrab);
    run.Run(300);
    ASSERT_EQ(run.peer().ownership().held(), 0);
    run.device->now.X_WA.p.y() = 0.002;
    run.Run(10);
    ASSERT_GT(run.device->felt.f.norm(), 0.05);
    cause = true;
    run.Run(10);  // six frames from the limit to nothing
    EXPECT_TRUE(run.device->felt.f.isZero());
    EXPECT_GE(run.device->stops, button ? 1 : 0);
    const SafetyState state = button ? SafetyState::kStopped : SafetyState::kFault;
    EXPECT_EQ(run.peer().safety_state(), state);
    run.Order(Command::Kind::kResume);
    run.Run(50);
    EXPECT_EQ(run.peer().safety_state(), state) << "while the cause lasts";
    run.largest = 0;
    run.Run(50);
    EXPECT_EQ(run.largest, 0.0);
    cause = false;
    run.Run(50);
    EXPECT_EQ(run.largest, 0.0);
    EXPECT_EQ(run.peer().ownership().held(), button ? -1 : 0) << "a stopped hand lets go";
    run.Order(Command::Kind::kResume);
    run.Order(Command::Kind::kGrab);
    run.Run(20);
    run.device->now.X_WA.p.y() += 0.002;
    run.Run(20);
    EXPECT_EQ(run.peer().safety_state(), SafetyState::kRamping);
    EXPECT_GT(run.largest, 0.0);
  }
}

// A handle that a rate moves is told the force so that it does not run ahead. It has to hear of the
// force while it is in trouble, too, and after that without a person's word.
TEST(PeerGuard, FaultOfAMotorlessDeviceKeepsTheForce) {
  GuardedSession run(0);
  run.Order(Command::Kind::kGrab);
  run.Run(300);
  for (const bool trouble : {true, false}) {
    run.device->in_trouble = trouble;
    run.device->now.X_WA.p.y() += 0.002;
    run.Run(10);
    EXPECT_EQ(run.peer().safety_state(), SafetyState::kOn);
    EXPECT_GT(run.device->felt.f.norm(), 0.05);
    run.Run(50);
  }
}

}  // namespace
}  // namespace tandem
