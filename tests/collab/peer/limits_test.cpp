// Tests the room of a session: how many peers take part, hold one body, and see how many bodies.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collab/session/viewer.h"
#include "collab/simulated/network/simulated_session.h"
#include "engine/haptics/scripted_device.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Returns so many boxes in a row, the first of them shared.
std::shared_ptr<const WorldModel> Boxes(int count) {
  std::vector<testing::TestBody> bodies;
  for (int i = 0; i < count; ++i) {
    bodies.push_back({testing::At(testing::Box(Vec3(0.01, 0.01, 0.01)), Vec3(0.1 * i, 0, 0))});
  }
  auto model = std::make_shared<WorldModel>(*testing::MakeWorldModel(bodies, 0.005));
  model->scene.bodies[0].shared = true;
  return model;
}

std::unique_ptr<PeerNode> Node(const std::shared_ptr<const WorldModel>& model, PeerId id,
                               int object) {
  NodeOptions options;
  options.peer.id = id;
  options.peer.held_object = object;
  options.name = std::to_string(id);
  return std::make_unique<PeerNode>(
      model, std::make_unique<ScriptedDevice>(HandScript{}, model->bodies[0].X_WB0), 42, options);
}

TEST(PeerDirectory, AdmitsSixteenActivePeers) {
  PeerDirectory directory(1, 42);
  PeerInfo info;
  info.scene_hash = 42;
  const auto come = [&](PeerId id, Role role = Role::kActive) {
    info.peer = id;
    info.role = role;
    info.name = "peer " + std::to_string(id);
    directory.OnPeerInfo(info);
  };
  for (PeerId id = 2; id <= kMaxPeers; ++id) come(id);
  directory.TakeNotifications();
  MembershipChange change;
  while (directory.changes().TryPop(change)) {
  }
  come(50, Role::kViewer);
  come(17);
  come(18);
  EXPECT_THAT(directory.TakeNotifications(),
              ElementsAre("peer 50 (viewer) joined",
                          "peer 17 is not accepted: 16 active peers are here, the maximum",
                          "peer 18 is not accepted: 16 active peers are here, the maximum"));
  EXPECT_FALSE(directory.changes().TryPop(change)) << "the haptic thread hears nothing of them";
  come(17);
  EXPECT_THAT(directory.TakeNotifications(), IsEmpty()) << "it is said once";

  directory.OnPeerLeft(9);
  come(18);
  come(17);
  EXPECT_THAT(directory.TakeNotifications(), ElementsAre("peer 9 left", "peer 18 is accepted now"));
  ASSERT_TRUE(directory.changes().TryPop(change));
  EXPECT_EQ(change.peer, 9U);
  ASSERT_TRUE(directory.changes().TryPop(change));
  EXPECT_EQ(change.peer, 18U);
  EXPECT_EQ(change.kind, MembershipChange::Kind::kJoined);
  EXPECT_FALSE(directory.changes().TryPop(change));
}

TEST(PeerNode, TwoHighestIdsOfEighteenSimultaneousPeersAreRefused) {
  const auto model = Boxes(1);
  SimulatedSession session;
  for (PeerId id = 18; id >= 1; --id) session.Add(Node(model, id, -1), id);
  for (int i = 0; i < 1000; ++i) session.Step();
  for (std::size_t i = 0; i < 18; ++i) EXPECT_EQ(session.node(i).IsBeyondLimit(), i < 2) << i;
}

TEST(PeerNode, SeventeenthPeerIsRefusedWhateverItsId) {
  const auto model = Boxes(1);
  SimulatedSession session;
  for (PeerId id = 2; id <= 17; ++id) session.Add(Node(model, id, -1), id);
  for (int i = 0; i < 2000; ++i) session.Step();
  session.Add(Node(model, 1, -1), 1);
  for (int i = 0; i < 1000; ++i) session.Step();
  for (std::size_t i = 0; i < 17; ++i) EXPECT_EQ(session.node(i).IsBeyondLimit(), i == 16) << i;
}

std::vector<std::size_t> Links(SimulatedSession& session, std::size_t peers) {
  std::vector<std::size_t> counts;
  for (std::size_t i = 0; i < peers; ++i) {
    std::array<InstanceView, kMaxLinks> instances;
    counts.push_back(session.node(i).peer().shared()->Instances(instances));
  }
  return counts;
}

// A body has eight links: the ninth other hand is told, and coupled as soon as there is a place.
TEST(PeerNode, UncoupledHoldersBeyondNineAreNamed) {
  const auto model = Boxes(1);
  SimulatedSession session;
  for (PeerId id = 1; id <= 11; ++id) session.Add(Node(model, id, 0), id);
  std::size_t reported = 0;
  for (int i = 0; i < 2000; ++i) session.Step();
  for (std::size_t i = 0; i < 11; ++i) {
    for (const std::string& line : session.node(i).TakeNotifications()) {
      if (line.rfind("more than 9 hold ", 0) != 0) continue;
      ++reported;
      EXPECT_THAT(line, HasSubstr("your hand is not coupled to that of "));
    }
  }
  EXPECT_EQ(reported, 11U * 2U) << "each of two, once";
  EXPECT_THAT(Links(session, 11), Each(8U));
  session.Kill(9);
  session.Kill(10);
  for (int i = 0; i < 3000; ++i) session.Step();
  EXPECT_THAT(Links(session, 9), Each(8U));
}

/// Keeps what a viewer hears.
class ToViewer final : public Transport {
 public:
  explicit ToViewer(Viewer& viewer) : viewer_(&viewer) {}
  void Publish(const ObjectState&) override {}
  void Publish(const ObjectState&, const CouplingLinks&) override {}
  void Publish(const ViewFrame& frame) override { viewer_->OnView(frame, frame.sample_ns); }
  void Publish(const PeerInfo&) override {}
  void Publish(const Event&) override {}
  void Publish(const SceneManifest&) override {}
  void Leave() override {}

 private:
  Viewer* viewer_;
};

// A frame has room for 24 bodies: they come in turns.
TEST(PeerNode, SixtyParkedBodiesAreVisibleWithin100Milliseconds) {
  kHapticThread.Enter();
  kSenderThread.Enter();
  constexpr int kBodies = 60;
  const auto model = Boxes(kBodies);
  const auto node = Node(model, 1, -1);
  std::int64_t now_ns = 0;
  const auto frames = [&](int count, Transport* transport) {
    for (int i = 0; i < count; ++i) {
      node->HapticFrame(now_ns += 1'000'000);
      if (transport != nullptr) node->SendFrame(now_ns, *transport);
    }
  };
  for (ObjectId body = 0; body < kBodies; ++body) {
    ASSERT_TRUE(node->peer().commands().TryPush({Command::Kind::kGrab, body, 0}));
    frames(5, nullptr);
    ASSERT_EQ(node->peer().ownership().held(), static_cast<int>(body));
    // the last one stays in the hand
    if (body + 1 == kBodies) break;
    ASSERT_TRUE(node->peer().commands().TryPush({Command::Kind::kRelease, kNoObject, 0}));
    frames(5, nullptr);
  }
  Viewer viewer;
  ToViewer transport(viewer);
  frames(100, &transport);
  ASSERT_EQ(viewer.Picture().peers.size(), 1U);
  EXPECT_EQ(viewer.Picture().peers[0].bodies.size(), static_cast<std::size_t>(kBodies));
}

}  // namespace
}  // namespace tandem
