// Tests free bodies, which their authority simulates: they are with the peer whose hand pushed them
// last.
#include <gtest/gtest.h>

#include "collab/ownership/ownership.h"
#include "tests/collab/ownership/ownership_cluster.h"

namespace tandem {
namespace {

using testing::kOwn;
using testing::kShared;
using testing::OwnershipCluster;
using testing::TwoBodies;

constexpr int kDelay = 100;     // ms, one way
constexpr int kTouching = 250;  // ms

WorldModel OneFree() {
  WorldModel model = TwoBodies();
  model.scene.bodies[kOwn].free = true;
  return model;
}

/// Peers, of which some push the free body.
class OwnershipTouch : public ::testing::Test {
 protected:
  void Run(int frames, const std::vector<PeerId>& pushing) {
    for (int i = 0; i < frames; ++i) {
      for (const PeerId id : pushing) cluster_[id].NoteTouch(0);
      cluster_.Run(1);
    }
  }

  OwnershipCluster cluster_{{3, 5, 9}, kDelay, OneFree()};
};

TEST_F(OwnershipTouch, LowestPeerMovesUntouchedBodies) {
  Run(400, {});
  EXPECT_EQ(cluster_.Authority(0), 3U);
  EXPECT_TRUE(cluster_[3].Parks(0));
  EXPECT_FALSE(cluster_[5].Parks(0));
  EXPECT_EQ(cluster_.Authority(1), 3U);
  EXPECT_FALSE(cluster_[3].Parks(1)) << "nobody has to move that one";
  EXPECT_EQ(cluster_.doubles(), 0);
}

TEST_F(OwnershipTouch, PushingPeerBecomesAuthorityAfterARoundTrip) {
  Run(400, {});
  Run(2 * kDelay, {9});
  EXPECT_FALSE(cluster_[9].Parks(0));
  Run(3, {9});
  EXPECT_TRUE(cluster_[9].Parks(0));
  EXPECT_EQ(cluster_[9].held(), -1) << "it is in nobody's hand";
  Run(3 * kDelay, {});
  EXPECT_EQ(cluster_.Authority(0), 9U);
  EXPECT_EQ(cluster_.doubles(), 0);
}

TEST_F(OwnershipTouch, AuthorityThatPushesKeepsTheBody) {
  Run(400, {3});
  Run(2000, {3, 5});
  EXPECT_EQ(cluster_.Authority(0), 3U);
  EXPECT_EQ(cluster_[9].epoch(0), 1U);
  Run(kTouching + 250 + 2 * kDelay + 10, {5});
  EXPECT_TRUE(cluster_[5].Parks(0)) << "the other lets go of it";
  EXPECT_EQ(cluster_.doubles(), 0);
}

TEST_F(OwnershipTouch, NewAuthorityKeepsTheBodyForAWhile) {
  Run(400, {});
  // 9 pushed for a moment, longer ago than a touch counts for, when the push of another arrives
  Run(1, {9});
  Run(2 * kDelay + 4, {});
  ASSERT_TRUE(cluster_[9].Parks(0));
  ASSERT_EQ(cluster_[5].authority(0), 9U);
  Run(1, {5});
  Run(kDelay + 10, {});
  EXPECT_TRUE(cluster_[9].Parks(0));
  // a push that arrives later, while 9 does not push, takes the body
  Run(kTouching, {});
  Run(1, {5});
  Run(2 * kDelay + 10, {});
  EXPECT_TRUE(cluster_[5].Parks(0));
}

TEST_F(OwnershipTouch, HeldBodyDoesNotGoToAPushingPeer) {
  Run(400, {});
  cluster_[3].Ask(kOwn);
  Run(2 * kDelay, {});
  ASSERT_EQ(cluster_[3].held(), 0);
  Run(1000, {5});
  EXPECT_EQ(cluster_[3].held(), 0);
  EXPECT_EQ(cluster_.Authority(0), 3U);
}

TEST_F(OwnershipTouch, PushingAnUnfreeBodySendsNothing) {
  Run(400, {});
  cluster_[3].Ask(kShared);
  Run(400, {});
  cluster_[3].Release();
  Run(400, {});
  const std::uint32_t epoch = cluster_[3].epoch(1);
  for (int i = 0; i < 1000; ++i) {
    cluster_[5].NoteTouch(1);
    cluster_.Run(1);
  }
  EXPECT_EQ(cluster_.Authority(1), 3U);
  EXPECT_EQ(cluster_[3].epoch(1), epoch);
}

TEST_F(OwnershipTouch, LooseBodyOfALostAuthorityGoesToTheNextPeer) {
  Run(400, {});
  Run(2 * kDelay + 3, {9});
  Run(3 * kDelay, {});
  ASSERT_EQ(cluster_.Authority(0), 9U);
  cluster_.Kill(9);
  Run(3000, {});
  EXPECT_EQ(cluster_.Authority(0), 3U);
  EXPECT_TRUE(cluster_[3].Parks(0));
}

TEST_F(OwnershipTouch, OnlyTheAuthorityPlacesALooseFreeBody) {
  Run(400, {});
  ObjectState state;
  state.peer = 3;
  state.object = kOwn;
  state.epoch = 1;
  state.flags = kStateLoose;
  EXPECT_TRUE(cluster_[9].Accepts(state));
  state.peer = 5;
  EXPECT_FALSE(cluster_[9].Accepts(state));
  cluster_[3].Ask(kShared);
  Run(400, {});
  state.peer = 3;
  state.object = kShared;
  EXPECT_FALSE(cluster_[9].Accepts(state));
}

}  // namespace
}  // namespace tandem
