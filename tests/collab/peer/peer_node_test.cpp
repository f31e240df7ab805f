#include "collab/peer/peer_node.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collab/coupling/coupling_law.h"
#include "collab/mirror/mirror_compliance.h"
#include "collab/simulated/network/simulated_session.h"
#include "engine/haptics/scripted_device.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

std::shared_ptr<const WorldModel> SharedBox() {
  const TriangleMesh box = testing::Box(Vec3(0.03, 0.02, 0.02));
  const TriangleMesh plate =
      Transformed(testing::Box(Vec3(0.2, 0.2, 0.01)), {Quat::Identity(), Vec3(0, 0, -0.03)});
  auto model =
      std::make_shared<WorldModel>(*testing::MakeWorldModel({{plate, true}, {box}}, 0.001));
  model->scene.bodies[1].shared = true;
  return model;
}

HandScript Shift(const Vec3& by, double seconds) {
  HandScript script;
  script.waypoints = {{0, Vec3::Zero(), Quat::Identity()}, {seconds, by, Quat::Identity()}};
  return script;
}

std::unique_ptr<PeerNode> Node(const std::shared_ptr<const WorldModel>& model, PeerId id,
                               const HandScript& script, double delay_ms,
                               std::size_t wait_for = 1) {
  NodeOptions options;
  options.peer.id = id;
  options.peer.held_object = 1;
  options.peer.wait_for = wait_for;
  options.peer.trace_frames = 20000;
  options.name = std::to_string(id);
  options.conditions.delay_ms = delay_ms;
  return std::make_unique<PeerNode>(
      model, std::make_unique<ScriptedDevice>(script, model->bodies[0].X_WB0), 42, options);
}

const Vec3& PlaceOf(SimulatedSession& session, std::size_t peer) {
  return session.node(peer).peer().held_state()->X_WB.p;
}

TEST(PeerNode, HandStartsOnceTheLoopIsClosed) {
  const auto model = SharedBox();
  SimulatedSession session;
  session.Add(Node(model, 1, Shift(Vec3(0.05, 0, 0), 1), 100), 1);
  for (int i = 0; i < 1000; ++i) session.Step();
  EXPECT_FALSE(session.node(0).peer().started_ns());
  session.Add(Node(model, 2, Shift(Vec3(0.05, 0, 0), 1), 100), 2);
  for (int i = 0; i < 400; ++i) session.Step();
  ASSERT_TRUE(session.node(0).peer().started_ns());
  ASSERT_TRUE(session.node(1).peer().started_ns());
  const std::int64_t apart =
      *session.node(0).peer().started_ns() - *session.node(1).peer().started_ns();
  EXPECT_LE(std::abs(apart),
            110'000'000);  // within the delay: the first was heard before the second came
}

// One hand moves 60 mm, the other stands. The instances meet half way, as springs in series say.
TEST(PeerNode, TwoHandsPullTheirInstancesTogether) {
  const auto model = SharedBox();
  SimulatedSession session;
  session.Add(Node(model, 1, Shift(Vec3(0.06, 0, 0), 1), 100), 1);
  session.Add(Node(model, 2, Shift(Vec3::Zero(), 1), 100), 2);
  for (int i = 0; i < 8000; ++i) session.Step();
  // hand 300 N/m and coupling 800 N/m in series, 218 N/m a side; between them the link
  const double k_side = 1.0 / (1.0 / 300.0 + 1.0 / 800.0);
  const double loop = session.node(0).peer().mean_delay_s() * 2;
  const double k_link = DefaultLaw()->Link(LawInputsAt(loop, 2, 0.3 + 1.2)).stiffness;
  const double force = 0.06 / (1.0 / k_link + 2.0 / k_side);
  EXPECT_NEAR(PlaceOf(session, 0).x() - PlaceOf(session, 1).x(), force / k_link, 0.0006);
  EXPECT_NEAR(PlaceOf(session, 1).x(), force / k_side, 0.0003);
  EXPECT_NEAR(session.node(0).peer().report().links_B_W[0].f.x(), -force, 0.02 * force);
  EXPECT_NEAR(session.node(1).peer().report().links_B_W[0].f.x(), force, 0.02 * force);
}

TEST(PeerNode, LeaveFadesTheForceAndReturnIsNotFelt) {
  const auto model = SharedBox();
  SimulatedSession session;
  session.Add(Node(model, 1, Shift(Vec3(0.06, 0, 0), 1), 50), 1);
  session.Add(Node(model, 2, Shift(Vec3::Zero(), 1), 50), 2);
  for (int i = 0; i < 6000; ++i) session.Step();
  double last = session.node(0).peer().report().links_B_W[0].f.norm();
  EXPECT_GT(last, 1.0);
  session.Kill(1);
  double largest_step = 0;
  const auto watch = [&](int frames) {
    for (int i = 0; i < frames; ++i) {
      session.Step();
      const double force = session.node(0).peer().report().links_B_W[0].f.norm();
      largest_step = std::max(largest_step, std::abs(force - last));
      last = force;
    }
  };
  // a crash is noticed, and its pull has faded, within a second
  session.node(0).TakeNotifications();
  watch(1000);
  EXPECT_THAT(session.node(0).TakeNotifications(), ::testing::Contains("2 is lost"));
  EXPECT_EQ(last, 0.0);
  EXPECT_LT(largest_step, 0.1);  // N a frame
  watch(600);                    // the hand's way back
  EXPECT_NEAR(PlaceOf(session, 0).x(), 0.06, 1e-3);
  session.Add(Node(model, 2, Shift(Vec3::Zero(), 1), 50), 2);
  watch(3000);
  EXPECT_GT(last, 1.0);
  EXPECT_LT(largest_step, 0.1);
}

TEST(PeerNode, OwnBodiesAreMirroredAtOtherPeers) {
  auto model = std::make_shared<WorldModel>(*testing::MakeWorldModel(
      {{Transformed(testing::Box(Vec3(0.02, 0.02, 0.02)), {Quat::Identity(), Vec3(-0.05, 0, 0)})},
       {Transformed(testing::Box(Vec3(0.02, 0.02, 0.02)), {Quat::Identity(), Vec3(0.05, 0, 0)})}},
      0.001));
  SimulatedSession session;
  for (const PeerId id : {1, 2}) {
    NodeOptions options;
    options.peer.id = id;
    options.peer.held_object = static_cast<int>(id) - 1;
    options.peer.wait_for = 1;
    options.conditions.delay_ms = 20;
    const Vec3 inward(id == 1 ? 0.045 : -0.045, 0, 0);  // they would overlap by 10 mm
    session.Add(std::make_unique<PeerNode>(model,
                                           std::make_unique<ScriptedDevice>(
                                               Shift(inward, 1.5), model->bodies[id - 1].X_WB0),
                                           42, options),
                id);
  }
  std::array<int, 2> pressing{};  // frames of the last second
  for (int i = 0; i < 6000; ++i) {
    session.Step();
    for (std::size_t peer = 0; peer < 2 && i >= 5000; ++peer) {
      pressing[peer] += session.node(peer).peer().report().pushing_points > 0 ? 1 : 0;
    }
  }
  for (std::size_t peer = 0; peer < 2; ++peer) {
    const World& world = session.node(peer).world();
    // each presses against the other's mirror, which gives way a little: they rest, without a
    // bounce
    EXPECT_GT(pressing[peer], 990) << "peer " << peer;
    // exact boxes stay apart in each peer's eyes
    EXPECT_GT(world.state(1).X_WB.p.x() - world.state(0).X_WB.p.x(), 0.020);
    const double mirror_lag =
        (world.state(1 - peer).X_WB.p - session.node(1 - peer).world().state(1 - peer).X_WB.p)
            .norm();
    // the mirror gives way by the push over B/te
    const double push = session.node(peer).peer().report().hand_B_W.f.norm();
    const double k = MirrorCompliance::kDrag / DesignDelay(0.041);
    EXPECT_NEAR(mirror_lag, push / k, 1e-4);
  }
}

TEST(PeerNode, IsDeterministic) {
  const auto model = SharedBox();
  const auto run = [&] {
    SimulatedSession session;
    session.Add(Node(model, 1, Shift(Vec3(0.03, 0.01, -0.03), 1), 80), 1);
    session.Add(Node(model, 2, Shift(Vec3(0.03, -0.01, -0.03), 1), 80), 2);
    for (int i = 0; i < 3000; ++i) session.Step();
    return std::make_pair(PlaceOf(session, 0), PlaceOf(session, 1));
  };
  const auto first = run();
  const auto second = run();
  EXPECT_EQ(first.first, second.first);
  EXPECT_EQ(first.second, second.second);
}

TEST(PeerNode, AThousandHapticFramesAllocateNothing) {
  const auto model = SharedBox();
  SimulatedSession session;
  session.Add(Node(model, 1, Shift(Vec3(0.03, 0, -0.03), 1), 20), 1);
  session.Add(Node(model, 2, Shift(Vec3(0.03, 0, -0.03), 1), 20), 2);
  for (int i = 0; i < 500; ++i) session.Step();
  ASSERT_TRUE(session.node(0).peer().started_ns());
  kHapticThread.Enter();
  std::int64_t now_ns = session.now_ns();
  const testing::AllocationCounter counter;
  for (int i = 0; i < 1000; ++i) session.node(0).HapticFrame(now_ns += 1'000'000);
  EXPECT_EQ(counter.count(), 0);
}

/// Counts what is published.
class CountingTransport : public Transport {
 public:
  void Publish(const ObjectState&) override { ++states; }
  void Publish(const ObjectState&, const CouplingLinks&) override {
    ++states;
    ++links;
  }
  void Publish(const ViewFrame& frame) override {
    ++views;
    view = frame;
  }
  void Publish(const PeerInfo&) override { ++infos; }
  void Publish(const Event&) override {}
  void Publish(const SceneManifest&) override { ++scenes; }
  void Leave() override {}
  int states = 0, links = 0, views = 0, infos = 0, scenes = 0;
  ViewFrame view;
};

TEST(PeerNode, PublishesStatesAtItsRateAndViewsAtSixtyHertz) {
  kHapticThread.Enter();
  kSenderThread.Enter();
  kControlThread.Enter();
  const auto model = SharedBox();
  for (const double hz : {1000.0, 250.0, 100.0}) {
    NodeOptions options;
    options.peer.id = 1;
    options.peer.held_object = 1;
    options.publish_hz = hz;
    PeerNode node(model,
                  std::make_unique<ScriptedDevice>(Shift(Vec3::Zero(), 1), model->bodies[0].X_WB0),
                  42, options);
    CountingTransport transport;
    for (std::int64_t ms = 1; ms <= 2000; ++ms) {
      node.HapticFrame(ms * 1'000'000);
      node.SendFrame(ms * 1'000'000, transport);
    }
    for (std::int64_t ms = 0; ms < 400; ms += 20) node.ControlFrame(ms * 1'000'000, transport);
    EXPECT_NEAR(transport.states, 2.0 * hz, 2);
    EXPECT_EQ(transport.links, transport.states);
    EXPECT_NEAR(transport.views, 120, 2);
    EXPECT_EQ(transport.infos, 2);
    EXPECT_EQ(transport.scenes, 1);
    ASSERT_EQ(transport.view.count, 1U);
    EXPECT_NEAR(transport.view.bodies[0].X_W.p.norm(), 0.0, 1e-12);  // not moved yet
  }
}

TEST(PeerNode, AnnouncesItselfFiveTimesASecond) {
  kHapticThread.Enter();
  kControlThread.Enter();
  const auto model = SharedBox();
  NodeOptions options;
  options.peer.id = 1;
  PeerNode node(model,
                std::make_unique<ScriptedDevice>(Shift(Vec3::Zero(), 1), model->bodies[0].X_WB0),
                42, options);
  CountingTransport transport;
  // 50 calls a second, each up to 3 ms late
  for (std::int64_t call = 0; call < 1000; ++call) {
    const std::int64_t late_ns = 300'000 * ((call * 7) % 11);
    node.ControlFrame(20'000'000 * call + late_ns, transport);
  }
  EXPECT_EQ(transport.infos, 100);
}

/// A sender's clock. While the sender sleeps, the haptic thread does its frames, each so long after
/// its millisecond began.
class ClockBesideFrames final : public LoopClock {
 public:
  explicit ClockBesideFrames(PeerNode& node) : node_(&node) {}

  std::int64_t NowNs() noexcept override { return now_ns_; }
  std::int64_t ThreadCpuNs() noexcept override { return 0; }
  void SleepUntil(std::int64_t deadline_ns) noexcept override {
    while (DoneNs() <= deadline_ns) {
      kHapticThread.Enter();
      node_->HapticFrame(1'000'000 * ++frames_);
      kSenderThread.Enter();
    }
    now_ns_ = deadline_ns;
  }
  int frames() const { return frames_; }

 private:
  // Returns a time from 0.02 to 0.72 ms, in no order.
  std::int64_t DoneNs() const {
    return 1'000'000 * (frames_ + 1) + 20'000 + 100'000 * ((frames_ * 5) % 8);
  }

  PeerNode* node_;
  int frames_ = 0;
  std::int64_t now_ns_ = 1'000'000;
};

TEST(PeerNode, EveryFrameIsSentOnce) {
  const auto model = SharedBox();
  NodeOptions options;
  options.peer.id = 1;
  options.peer.held_object = 1;
  PeerNode node(model,
                std::make_unique<ScriptedDevice>(Shift(Vec3::Zero(), 1), model->bodies[0].X_WB0),
                42, options);
  CountingTransport transport;
  ClockBesideFrames clock(node);
  kSenderThread.Enter();
  // until the body is in hand
  std::int64_t ms = 1;
  for (; transport.states == 0; ++ms) {
    ASSERT_LT(ms, 1000);
    clock.SleepUntil(1'000'000 * ms + kSenderPhaseNs);
    SendWhenDone(node, transport, clock);
  }
  const int before = clock.frames() - transport.states;
  for (int sent = transport.states; ms < 2000; ++ms) {
    clock.SleepUntil(1'000'000 * ms + kSenderPhaseNs);
    SendWhenDone(node, transport, clock);
    EXPECT_EQ(transport.states, ++sent) << ms;
  }
  EXPECT_EQ(clock.frames() - transport.states, before);
}

}  // namespace
}  // namespace tandem
