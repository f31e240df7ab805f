#include "collab/ownership/ownership.h"

#include <gtest/gtest.h>

#include "tests/collab/ownership/ownership_cluster.h"

namespace tandem {
namespace {

using testing::kOwn;
using testing::kShared;
using testing::OwnershipCluster;
using Kind = MembershipChange::Kind;

TEST(Ownership, LowestPeerOwnsUntouchedBodies) {
  OwnershipCluster cluster({3, 5, 9});
  cluster.Run(10);
  EXPECT_EQ(cluster.Authority(0), 3U);
  EXPECT_EQ(cluster[5].epoch(0), 0U);
  EXPECT_FALSE(cluster[3].Parks(0)) << "it stands where all know";
}

TEST(Ownership, AGrabIsGrantedWithinARoundTrip) {
  OwnershipCluster cluster({3, 5, 9}, 100);
  cluster.Run(10);
  cluster[5].Ask(kOwn);
  cluster.Run(199);
  EXPECT_EQ(cluster[5].held(), -1);
  cluster.Run(3);
  EXPECT_EQ(cluster[5].held(), 0);
  cluster.Run(200);
  EXPECT_EQ(cluster.Authority(0), 5U);
  EXPECT_EQ(cluster[9].epoch(0), 1U);
  EXPECT_TRUE(cluster[9].HeldBy(0, 5));
  EXPECT_EQ(cluster.doubles(), 0);
}

TEST(Ownership, GrantOfAWithdrawnRequestIsNotHeld) {
  OwnershipCluster cluster({3, 5}, 100);
  cluster.Run(10);
  cluster[5].Ask(kOwn);
  cluster.Run(50);
  cluster[5].Release();
  cluster.Run(400);
  EXPECT_EQ(cluster[5].held(), -1);
  EXPECT_EQ(cluster.Authority(0), 5U) << "it was granted all the same";
  cluster[5].Ask(kOwn);
  cluster.Run(50);
  EXPECT_EQ(cluster[5].held(), 0) << "and may be taken anew";
}

TEST(Ownership, SupersededRequestIsNotGrantedIntoTheHand) {
  OwnershipCluster cluster({3, 5}, 100);
  cluster.Run(10);
  cluster[5].Ask(kOwn);
  cluster.Run(20);
  cluster[5].Ask(kShared);
  cluster.Run(20);
  cluster[5].Release();
  cluster.Run(600);
  EXPECT_EQ(cluster[5].held(), -1);
  EXPECT_EQ(cluster.Authority(0), 5U) << "it was granted all the same";
}

TEST(Ownership, StoppedHandOwnsAGivenBodyWithoutHoldingIt) {
  OwnershipCluster cluster({3, 5}, 10);
  cluster[5].Ask(kOwn);
  cluster.Run(50);
  ASSERT_EQ(cluster[5].held(), 0);
  cluster[3].Stop();
  cluster[5].Give(3);
  cluster.Run(50);
  EXPECT_EQ(cluster[3].held(), -1);
  EXPECT_TRUE(cluster[3].Parks(0));
  cluster[3].Resume();
  cluster[5].Ask(kOwn);
  cluster.Run(50);
  cluster[5].Give(3);
  cluster.Run(50);
  EXPECT_EQ(cluster[3].held(), 0);
}

TEST(Ownership, RequestForAHeldBodyIsGrantedAfterRelease) {
  OwnershipCluster cluster({3, 5}, 10);
  cluster[5].Ask(kOwn);
  cluster.Run(50);
  ASSERT_EQ(cluster[5].held(), 0);
  cluster[3].Ask(kOwn);
  cluster.Run(50);
  EXPECT_EQ(cluster[3].held(), -1);
  EXPECT_EQ(cluster[3].wanted(), -1);
  Notification notification;
  ASSERT_TRUE(cluster[3].TakeNotifications(notification));
  EXPECT_EQ(notification.kind, Notification::Kind::kAsking);
  ASSERT_TRUE(cluster[3].TakeNotifications(notification));
  EXPECT_EQ(notification.kind, Notification::Kind::kRefused);
  EXPECT_EQ(notification.peer, 5U);

  cluster[5].SetPose(0, {Quat::Identity(), Vec3(1, 2, 3)});
  cluster[5].Release();
  cluster.Run(50);
  EXPECT_TRUE(cluster[5].Parks(0));
  ASSERT_NE(cluster[3].ParkedAt(0), nullptr);
  EXPECT_EQ(cluster[3].ParkedAt(0)->p, Vec3(1, 2, 3));
  cluster[3].Ask(kOwn);
  cluster.Run(50);
  EXPECT_EQ(cluster[3].held(), 0);
  EXPECT_EQ(cluster.Authority(0), 3U);
  EXPECT_EQ(cluster.doubles(), 0);
}

TEST(Ownership, HolderIsToldOfARequestOnce) {
  OwnershipCluster cluster({3, 5}, 10);
  cluster[5].Ask(kOwn);
  cluster.Run(50);
  ASSERT_EQ(cluster[5].held(), 0);
  Notification notification;
  while (cluster[5].TakeNotifications(notification)) {
  }
  for (int i = 0; i < 3; ++i) {
    cluster[3].Ask(kOwn);
    cluster.Run(50);
  }
  ASSERT_TRUE(cluster[5].TakeNotifications(notification));
  EXPECT_EQ(notification.kind, Notification::Kind::kAsked);
  EXPECT_EQ(notification.object, kOwn);
  EXPECT_EQ(notification.peer, 3U);
  EXPECT_FALSE(cluster[5].TakeNotifications(notification)) << "asked thrice in 150 ms";
  cluster.Run(2000);
  cluster[3].Ask(kOwn);
  cluster.Run(50);
  ASSERT_TRUE(cluster[5].TakeNotifications(notification)) << "asked again later";
  EXPECT_EQ(notification.kind, Notification::Kind::kAsked);
}

TEST(Ownership, HolderIsToldOfEachRequesterOnce) {
  OwnershipCluster cluster({3, 5, 9}, 10);
  cluster[5].Ask(kOwn);
  cluster.Run(50);
  ASSERT_EQ(cluster[5].held(), 0);
  Notification notification;
  while (cluster[5].TakeNotifications(notification)) {
  }
  for (int i = 0; i < 4; ++i) {
    cluster[i % 2 == 0 ? 3 : 9].Ask(kOwn);
    cluster.Run(50);
  }
  for (const PeerId asker : {3U, 9U}) {
    ASSERT_TRUE(cluster[5].TakeNotifications(notification));
    EXPECT_EQ(notification.kind, Notification::Kind::kAsked);
    EXPECT_EQ(notification.peer, asker);
  }
  EXPECT_FALSE(cluster[5].TakeNotifications(notification)) << "each asked twice in 200 ms";
  cluster.Run(2000);
  cluster[9].Ask(kOwn);
  cluster.Run(50);
  ASSERT_TRUE(cluster[5].TakeNotifications(notification)) << "asked again later";
  EXPECT_EQ(notification.peer, 9U);
}

TEST(Ownership, SimultaneousRequestsAreGrantedToOnePeer) {
  OwnershipCluster cluster({3, 5, 9}, 40);
  cluster.Run(10);
  cluster[5].Ask(kOwn);
  cluster[9].Ask(kOwn);
  cluster.Run(6000);
  EXPECT_EQ(cluster.Holders(0).size(), 1U);
  EXPECT_NE(cluster.Authority(0), 0U);
  EXPECT_EQ(cluster.doubles(), 0);
}

TEST(Ownership, HandoverPutsTheBodyIntoTheOtherHand) {
  OwnershipCluster cluster({3, 5, 9}, 20);
  cluster[9].Ask(kOwn);
  cluster.Run(100);
  ASSERT_EQ(cluster[9].held(), 0);
  cluster[9].Give(5);
  cluster.Run(100);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{5});
  EXPECT_EQ(cluster.Authority(0), 5U);
  EXPECT_EQ(cluster.doubles(), 0);
}

TEST(Ownership, LeavingPeerPassesEverythingToTheLowestPeer) {
  OwnershipCluster cluster({3, 5, 9}, 20);
  cluster[5].Ask(kOwn);
  cluster.Run(100);
  cluster.Leave(5);
  cluster.Run(2);
  EXPECT_EQ(cluster.Authority(0), 3U);
  EXPECT_TRUE(cluster[3].Parks(0));
  EXPECT_EQ(cluster.doubles(), 0);
}

TEST(Ownership, LowestPeerTakesOverWithin300MillisecondsOfACrash) {
  OwnershipCluster cluster({3, 5, 9}, 20);
  cluster[3].Ask(kOwn);
  cluster.Run(100);
  ASSERT_EQ(cluster[3].held(), 0);
  cluster.Kill(3);
  cluster.Run(299);
  EXPECT_EQ(cluster.Authority(0), 3U);
  cluster.Run(30);
  EXPECT_EQ(cluster.Authority(0), 5U);
  EXPECT_EQ(cluster[9].epoch(0), 2U);
  cluster[9].Ask(kOwn);
  cluster.Run(100);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{9});
  EXPECT_EQ(cluster.doubles(), 0);
}

TEST(Ownership, ResumedHolderGetsItsBodyBackWithOneMessage) {
  OwnershipCluster cluster({3, 5, 9}, 5);
  cluster[9].Ask(kOwn);
  cluster.Run(100);
  ASSERT_EQ(cluster[9].held(), 0);
  cluster.Stop(9, true);
  cluster.Run(600);  // the lease
  cluster.Sever(9);
  cluster.Run(2400);
  EXPECT_EQ(cluster[3].authority(0), 3U);
  EXPECT_TRUE(cluster[3].Parks(0));
  cluster.Stop(9, false);
  cluster.Run(100);
  cluster.Rejoin(9);
  cluster.Run(600);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{9});
  EXPECT_EQ(cluster.Authority(0), 9U);
  EXPECT_EQ(cluster.doubles(), 0);
}

TEST(Ownership, SharedBodyIsHeldJointlyAndParkedByTheLastHolder) {
  OwnershipCluster cluster({3, 5, 9}, 20);
  cluster[5].Ask(kShared);
  cluster.Run(100);
  EXPECT_EQ(cluster.Authority(1), 5U);
  cluster[9].Ask(kShared);
  cluster[3].Ask(kShared);
  cluster.Run(100);
  EXPECT_EQ(cluster.Holders(1), (std::vector<PeerId>{3, 5, 9}));
  EXPECT_EQ(cluster.Authority(1), 3U) << "the lowest holder";
  cluster[3].Release();
  cluster.Run(100);
  EXPECT_EQ(cluster.Authority(1), 5U);
  cluster[3].Ask(kShared);
  cluster[5].Release();
  cluster.Run(100);
  EXPECT_EQ(cluster.Holders(1), (std::vector<PeerId>{3, 9}));
  EXPECT_EQ(cluster.Authority(1), 9U) << "the lowest holder that it knew of";
  EXPECT_FALSE(cluster[9].Parks(1));
  cluster.Kill(9);
  cluster.Run(400);
  EXPECT_EQ(cluster.Authority(1), 3U) << "the holder that is left";
  cluster[3].Release();
  cluster.Run(100);
  EXPECT_EQ(cluster.Authority(1), 3U);
  EXPECT_TRUE(cluster[3].Parks(1));
}

TEST(Ownership, LateJoinerLearnsTheAuthorities) {
  OwnershipCluster cluster({5, 9}, 20);
  cluster[9].Ask(kOwn);
  cluster.Run(100);
  cluster.Add(3);
  cluster.Run(100);
  EXPECT_EQ(cluster.Authority(0), 9U);
  cluster[3].Ask(kOwn);
  cluster.Run(100);
  EXPECT_EQ(cluster[3].held(), -1);
  EXPECT_EQ(cluster.doubles(), 0);
}

// The others have decided without it what it missed. It knows that it was stopped before it judges,
// asks nobody to give way at once, and answers no question from before.
TEST(Ownership, ResumedPeerListensBeforeItClaims) {
  OwnershipCluster cluster({3, 5, 9});
  cluster[3].Ask(kOwn);
  cluster.Run(6000);
  ASSERT_EQ(cluster[3].held(), 0);
  cluster.Stop(3, true);
  for (const PeerId peer : {5U, 9U}) cluster[peer].OnMembership({.kind = Kind::kLost, .peer = 3});
  cluster.Run(1000);
  ASSERT_EQ(cluster[5].authority(0), 5U);
  cluster.Stop(3, false);
  MembershipChange claims{.kind = Kind::kClaims, .peer = 5, .claim_count = 1};
  claims.claims[0] = {kOwn, cluster[5].epoch(0), false};
  cluster[3].Begin(8'000'000'000);
  cluster[3].OnMembership(claims);
  cluster[3].Settle();
  EXPECT_LT(cluster[3].epoch(0), 3U) << "not claimed anew";
  EXPECT_TRUE(cluster[3].listening());
}

// The peer that answers for the body is here and holds something else. It goes on to answer.
TEST(Ownership, LastHolderLeavesASharedBodyToItsAuthority) {
  OwnershipCluster cluster({3, 5, 9}, 10);
  cluster[9].Ask(kShared);
  cluster.Run(100);
  cluster[5].Ask(kShared);
  cluster.Run(100);
  cluster[5].Ask(kOwn);  // lets go of the shared one, which 9 has then
  cluster.Run(100);
  cluster[9].Give(5);
  cluster[3].Ask(kShared);
  cluster.Run(100);
  const PeerId authority = cluster.Authority(1);
  const std::uint32_t epoch = cluster[authority].epoch(1);
  ASSERT_NE(authority, 0U);
  for (const PeerId peer : {3U, 5U, 9U}) {
    if (peer != authority) cluster[peer].Release();
  }
  cluster.Run(100);
  EXPECT_EQ(cluster.Authority(1), authority);
  EXPECT_EQ(cluster[authority].epoch(1), epoch);
}

// Its force parameters are not the others'. It answers for a body that it is given, but does not
// hold it.
TEST(Ownership, PeerWithOtherParametersCannotTakeSharedBodies) {
  OwnershipCluster cluster({1}, 3);
  cluster.Add(2, true);
  cluster[1].Ask(kShared);
  cluster.Run(50);
  ASSERT_EQ(cluster.Holders(1), std::vector<PeerId>{1});
  cluster[2].Ask(kShared);
  cluster.Run(50);
  EXPECT_EQ(cluster[2].wanted(), -1);
  EXPECT_EQ(cluster.Holders(1), std::vector<PeerId>{1});
  cluster[1].Give(2);
  cluster.Run(50);
  EXPECT_TRUE(cluster.Holders(1).empty());
  EXPECT_EQ(cluster.Authority(1), 2U);
  EXPECT_TRUE(cluster[2].Parks(1));
  cluster[2].Ask(kOwn);
  cluster.Run(50);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{2});
}

}  // namespace
}  // namespace tandem
