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
      for (const PeerId id : pushing) company_[id].NoteTouch(0);
      company_.Run(1);
    }
  }

  OwnershipCluster company_{{3, 5, 9}, kDelay, OneFree()};
};

TEST_F(OwnershipTouch, LowestPeerMovesUntouchedBodies) {
  Run(400, {});
  EXPECT_EQ(company_.Authority(0), 3U);
  EXPECT_TRUE(company_[3].Parks(0));
  EXPECT_FALSE(company_[5].Parks(0));
  EXPECT_EQ(company_.Authority(1), 3U);
  EXPECT_FALSE(company_[3].Parks(1)) << "nobody has to move that one";
  EXPECT_EQ(company_.doubles(), 0);
}

TEST_F(OwnershipTouch, PushingPeerBecomesOwnerAfterARoundTrip) {
  Run(400, {});
  Run(2 * kDelay, {9});
  EXPECT_FALSE(company_[9].Parks(0));
  Run(3, {9});
  EXPECT_TRUE(company_[9].Parks(0));
  EXPECT_EQ(company_[9].held(), -1) << "it is in nobody's hand";
  Run(3 * kDelay, {});
  EXPECT_EQ(company_.Authority(0), 9U);
  EXPECT_EQ(company_.doubles(), 0);
}

TEST_F(OwnershipTouch, OwnerThatPushesKeepsTheBody) {
  Run(400, {3});
  Run(2000, {3, 5});
  EXPECT_EQ(company_.Authority(0), 3U);
  EXPECT_EQ(company_[9].epoch(0), 1U);
  Run(kTouching + 250 + 2 * kDelay + 10, {5});
  EXPECT_TRUE(company_[5].Parks(0)) << "the other lets go of it";
  EXPECT_EQ(company_.doubles(), 0);
}

TEST_F(OwnershipTouch, NewOwnerKeepsTheBodyForAWhile) {
  Run(400, {});
  // 9 pushed for a moment, longer ago than a touch counts for, when the push of another arrives
  Run(1, {9});
  Run(2 * kDelay + 4, {});
  ASSERT_TRUE(company_[9].Parks(0));
  ASSERT_EQ(company_[5].authority(0), 9U);
  Run(1, {5});
  Run(kDelay + 10, {});
  EXPECT_TRUE(company_[9].Parks(0));
  // a push that arrives later, while 9 does not push, takes the body
  Run(kTouching, {});
  Run(1, {5});
  Run(2 * kDelay + 10, {});
  EXPECT_TRUE(company_[5].Parks(0));
}

TEST_F(OwnershipTouch, HeldBodyDoesNotGoToAPushingPeer) {
  Run(400, {});
  company_[3].Ask(kOwn);
  Run(2 * kDelay, {});
  ASSERT_EQ(company_[3].held(), 0);
  Run(1000, {5});
  EXPECT_EQ(company_[3].held(), 0);
  EXPECT_EQ(company_.Authority(0), 3U);
}

TEST_F(OwnershipTouch, PushingAnUnfreeBodySendsNothing) {
  Run(400, {});
  company_[3].Ask(kShared);
  Run(400, {});
  company_[3].Release();
  Run(400, {});
  const std::uint32_t epoch = company_[3].epoch(1);
  for (int i = 0; i < 1000; ++i) {
    company_[5].NoteTouch(1);
    company_.Run(1);
  }
  EXPECT_EQ(company_.Authority(1), 3U);
  EXPECT_EQ(company_[3].epoch(1), epoch);
}

TEST_F(OwnershipTouch, LooseBodyOfALostOwnerGoesToTheNextPeer) {
  Run(400, {});
  Run(2 * kDelay + 3, {9});
  Run(3 * kDelay, {});
  ASSERT_EQ(company_.Authority(0), 9U);
  company_.Kill(9);
  Run(3000, {});
  EXPECT_EQ(company_.Authority(0), 3U);
  EXPECT_TRUE(company_[3].Parks(0));
}

TEST_F(OwnershipTouch, OnlyTheOwnerPlacesALooseFreeBody) {
  Run(400, {});
  ObjectState state;
  state.peer = 3;
  state.object = kOwn;
  state.epoch = 1;
  state.flags = kStateLoose;
  EXPECT_TRUE(company_[9].Accepts(state));
  state.peer = 5;
  EXPECT_FALSE(company_[9].Accepts(state));
  company_[3].Ask(kShared);
  Run(400, {});
  state.peer = 3;
  state.object = kShared;
  EXPECT_FALSE(company_[9].Accepts(state));
}

}  // namespace
}  // namespace tandem
