#include <gtest/gtest.h>

#include "collab/ownership/ownership.h"
#include "tests/collab/ownership/listener.h"
#include "tests/collab/ownership/ownership_cluster.h"

// A member that lies, or has not heard yet, takes nothing from others: docs/decisions/0056.

namespace tandem {
namespace {

using testing::kLiar;
using testing::kOwn;
using testing::kShared;
using testing::Listener;
using testing::OwnershipCluster;
using Kind = MembershipChange::Kind;

// If each newcomer let a peer's allowance begin anew, the peer would be believed anything, by its
// own comings, too.
TEST(OwnershipMisled, RejoiningGivesNoMoreCredit) {
  Listener three(3);
  three.HearClaim(kLiar, 1, false, Kind::kJoined);
  three.Run(6000);
  ASSERT_EQ(three.ownership().authority(0), kLiar);
  constexpr int kComings = 1000;
  for (int i = 0; i < kComings; ++i) {
    three.HearGone(kLiar, Kind::kLost);
    three.HearClaim(kLiar, three.ownership().epoch(0) + 90, false, Kind::kJoined);
    three.Run(20);
  }
  constexpr int kSeconds = kComings / 50;
  EXPECT_LE(three.ownership().epoch(0), 1U + 1000 + 100 + 2 * 10 * (kSeconds + 6));
}

// Answers to all would be more than others hear of one peer, and its own words would be lost.
TEST(OwnershipMisled, RequestFloodGetsFewAnswers) {
  Listener nine(9);
  nine.ownership().Ask(kOwn);
  nine.Run(10);
  ASSERT_EQ(nine.ownership().held(), 0);
  nine.HearName(kLiar, 9, 1, Kind::kJoined);
  const std::size_t before = nine.stated();
  for (int i = 0; i < 1000; ++i) {
    nine.Hear(EventKind::kAsk, kLiar, 9, 1);
    nine.Run(1);
  }
  EXPECT_GE(nine.stated() - before, 10U);
  EXPECT_LE(nine.stated() - before, 30U);
  EXPECT_EQ(nine.ownership().held(), 0);
}

// Until the others have heard of a new epoch they drop the states that bear it.
TEST(OwnershipMisled, EpochOfAHeldSharedBodyIsStable) {
  for (const bool by_release : {true, false}) {
    Listener three(3, kShared);
    three.ownership().Ask(kShared);
    three.Run(10);
    ASSERT_EQ(three.ownership().held(), 1);
    const std::uint32_t first = three.ownership().epoch(1);
    three.HearName(kLiar, 3, first, Kind::kJoined);
    three.Run(100);
    for (int i = 0; i < 500; ++i) {
      const std::uint32_t above = three.ownership().epoch(1) + 1;
      if (by_release) {
        three.Hear(EventKind::kRelease, kLiar, 3, above);
      } else {
        three.HearName(kLiar, 3, above);
      }
      three.Run(1);
    }
    EXPECT_LE(three.ownership().epoch(1), first + 2) << by_release;
    EXPECT_EQ(three.ownership().held(), 1);
  }
}

// As many peers name the one as the other, and both know who has the body in hand.
TEST(OwnershipMisled, HolderKeepsTheBodyOnATie) {
  Listener nine(9);
  nine.ownership().Ask(kOwn);
  nine.Run(10);
  ASSERT_EQ(nine.ownership().held(), 0);
  nine.HearClaim(5, 3, false, Kind::kJoined);
  nine.Run(1000);
  EXPECT_EQ(nine.ownership().held(), 0);
  Listener three(3);
  three.ownership().Ask(kOwn);
  three.Run(10);
  three.ownership().Release();
  three.HearClaim(5, 3, true, Kind::kJoined);
  three.Run(10);
  EXPECT_EQ(three.ownership().authority(0), 5U);
}

TEST(OwnershipMisled, ResumedPeerClaimsABodyAttributedToIt) {
  OwnershipCluster cluster({5, 9}, 0);
  cluster[9].Ask(kOwn);
  cluster.Run(2000);
  ASSERT_EQ(cluster.Holders(0), std::vector<PeerId>{9});
  cluster.Stop(9, true);
  cluster.Run(600);
  MembershipChange forged{.kind = Kind::kJoined, .peer = kLiar, .claim_count = 1};
  forged.claims[0] = {kOwn, 40, true};
  for (const PeerId peer : {5U, 9U}) cluster[peer].OnMembership(forged);
  cluster.Stop(9, false);
  cluster.Run(300);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{9});
  EXPECT_EQ(cluster.Authority(0), 9U);
}

// The liar tells a newcomer that the body is its own, while a hand holds it.
TEST(OwnershipMisled, NewcomerDoesNotTakeAHeldBody) {
  Listener nine(9);
  nine.HearClaim(kLiar, 5, false, Kind::kJoined);
  nine.Run(1);
  ASSERT_EQ(nine.ownership().authority(0), kLiar);
  nine.HearClaim(5, 3, true, Kind::kJoined);
  nine.ownership().Ask(kOwn);
  nine.Run(1);
  nine.HearGrant(kLiar, 9, 6);
  nine.Run(100);
  EXPECT_EQ(nine.ownership().held(), -1);
  nine.HearGone(5, Kind::kLeft);
  nine.Run(1);
  EXPECT_EQ(nine.ownership().held(), 0) << "nobody holds it any more";
}

// The owner is cut off from this peer, and the peer that has the body from it is still to be heard.
TEST(OwnershipMisled, LostAuthoritysBodyDoesNotGoToAClaimantAtOnce) {
  Listener three(3);
  three.HearClaim(5, 1, true, Kind::kJoined);
  three.HearName(9, 5, 1, Kind::kJoined);
  three.HearGone(kLiar, Kind::kJoined);
  three.Run(6000);
  three.HearGone(5, Kind::kLost);
  three.HearClaim(kLiar, 6, false);
  three.Run(100);
  EXPECT_EQ(three.ownership().authority(0), 5U);
  three.Run(300);
  EXPECT_EQ(three.ownership().authority(0), kLiar);
}

// One honest peer was misled, so that two name the liar. This one knows the owner's claim itself.
TEST(OwnershipMisled, PeerCountsItsOwnVoteForTheClaimThatItKnows) {
  Listener three(3);
  three.HearClaim(5, 1, true, Kind::kJoined);
  three.HearName(9, 5, 1, Kind::kJoined);
  three.HearGone(kLiar, Kind::kJoined);
  three.Run(6000);
  three.HearClaim(kLiar, 6, false);
  three.HearName(9, kLiar, 6);
  three.Run(1000);
  EXPECT_EQ(three.ownership().authority(0), 5U);
}

// 3 took the body over while 5 was away, and claimed above 5 while 7 went by 3 still. Now 7 goes by
// 5. Under its own name 3 never counts back.
TEST(OwnershipMisled, AuthorityYieldsToTheMajorityAndKeepsCountingEpochs) {
  Listener three(3);
  three.HearClaim(5, 1, false, Kind::kJoined);
  three.HearName(7, 5, 1, Kind::kJoined);
  three.Run(6000);
  three.HearGone(5, Kind::kLost);
  three.Run(400);
  ASSERT_EQ(three.ownership().authority(0), 3U);
  three.HearName(7, 3, 2);
  three.HearClaim(5, 3, false, Kind::kBack);
  three.Run(10);
  ASSERT_EQ(three.ownership().authority(0), 3U);
  ASSERT_EQ(three.ownership().epoch(0), 4U);
  three.HearName(7, 5, 3);
  three.Run(1);
  EXPECT_EQ(three.ownership().authority(0), 5U);
  three.HearGrant(5, 3, 4);
  three.Run(1);
  EXPECT_EQ(three.ownership().authority(0), 3U);
  EXPECT_EQ(three.ownership().epoch(0), 5U);
}

// The same holds as for a body of one hand: to wait for a claim above ours would take two ways
// more.
TEST(OwnershipMisled, SharedBodysAuthorityYieldsToTheMajority) {
  Listener three(3, kShared);
  three.HearClaim(5, 1, false, Kind::kJoined);
  three.HearName(7, 5, 1, Kind::kJoined);
  three.Run(6000);
  three.HearGone(5, Kind::kLost);
  three.Run(400);
  ASSERT_EQ(three.ownership().authority(1), 3U);
  three.HearName(7, 3, 2);
  three.HearClaim(5, 3, false, Kind::kBack);
  three.Run(10);
  ASSERT_EQ(three.ownership().epoch(1), 4U);
  three.HearName(7, 5, 3);
  three.Run(1);
  EXPECT_EQ(three.ownership().authority(1), 5U);
  three.HearClaim(5, 3, true);
  three.ownership().Ask(kShared);
  three.Run(1);
  ASSERT_EQ(three.ownership().held(), 1);
  EXPECT_EQ(three.ownership().own_epoch(1), 4U) << "what it says never goes back";
  EXPECT_EQ(three.ownership().authority(1), 5U);
}

// Two name the liar, as they were misled under an epoch that anybody may claim (hostile seed 619).
TEST(OwnershipMisled, NamesUnderALowEpochDoNotSupportAHighOne) {
  for (const bool by_grant : {false, true}) {
    constexpr PeerId kLowest = 2;
    Listener nine(9);
    nine.HearName(3, kLowest, 900, Kind::kJoined);
    nine.HearName(5, kLowest, 900, Kind::kJoined);
    nine.Run(1100);
    if (by_grant) {
      nine.HearName(kLowest, 0, 0, Kind::kJoined);
      nine.HearGrant(kLowest, 9, 5000);
    } else {
      nine.HearClaim(kLowest, 5000, false, Kind::kJoined);
    }
    nine.Run(10);
    EXPECT_EQ(nine.ownership().epoch(0), 0U) << by_grant;
    nine.HearName(3, kLowest, 4999);
    nine.HearName(5, kLowest, 4950);
    if (by_grant) nine.HearGrant(kLowest, 9, 5000);
    nine.Run(1);
    EXPECT_EQ(nine.ownership().epoch(0), 5000U) << by_grant << ": in a session of long ago";
    EXPECT_EQ(nine.ownership().authority(0), by_grant ? 9U : kLowest);
  }
}

// The liar says that 5 has it under an epoch that 5 does not go by. To take it over from there
// would be a claim that the others go by as little (hostile seed 619).
TEST(OwnershipMisled, AuthoritysOwnLowerEpochIsAccepted) {
  Listener nine(9);
  nine.HearClaim(kLiar, 1, false, Kind::kJoined);
  nine.Run(6000);
  nine.HearName(kLiar, 5, 900);
  nine.HearClaim(5, 3, false, Kind::kJoined);
  nine.Run(2900);
  EXPECT_EQ(nine.ownership().authority(0), 5U);
  EXPECT_EQ(nine.ownership().epoch(0), 900U) << "it may raise its claim yet";
  nine.Run(200);
  EXPECT_EQ(nine.ownership().epoch(0), 3U);
  nine.HearClaim(5, 4, false);
  nine.Run(10000);
  EXPECT_EQ(nine.ownership().authority(0), 5U);
  EXPECT_EQ(nine.ownership().epoch(0), 4U);
}

// The liar gave it to each of two peers, and one had it in hand as the other took it. Only then
// does the other hear those who name them, and neither was ever away (hostile seed 388).
TEST(OwnershipMisled, LaterHolderYieldsOnATie) {
  enum class Case { kLater, kEarlier, kNamedByNobody, kLetGoMeanwhile };
  for (const PeerId self : {3U, 8U}) {
    for (const Case now :
         {Case::kLater, Case::kEarlier, Case::kNamedByNobody, Case::kLetGoMeanwhile}) {
      Listener peer(self);
      peer.HearClaim(kLiar, 1, false, Kind::kJoined);
      peer.HearName(7, kLiar, 1, Kind::kJoined);
      peer.HearName(9, kLiar, 1, Kind::kJoined);
      peer.HearName(5, kLiar, 1, Kind::kJoined);
      peer.Run(6000);
      if (now != Case::kEarlier) peer.HearClaim(5, 4, true);
      peer.ownership().Ask(kOwn);
      peer.Run(1);
      peer.HearGrant(kLiar, self, 5);
      peer.Run(1);
      ASSERT_EQ(peer.ownership().held(), 0);
      peer.HearGone(kLiar, Kind::kLeft);
      if (now == Case::kLetGoMeanwhile) peer.HearClaim(5, 4, false);
      const bool is_named = now != Case::kNamedByNobody;
      peer.HearName(7, is_named ? self : 0, 5);
      peer.HearName(9, is_named ? 5 : 0, 6);
      peer.HearClaim(5, 6, true);
      peer.Run(100);
      EXPECT_EQ(peer.ownership().held(), 0) << "the other may yield";
      peer.Run(2900);
      EXPECT_EQ(peer.ownership().held(), now == Case::kLater ? -1 : 0)
          << self << ' ' << static_cast<int>(now);
      EXPECT_EQ(peer.ownership().authority(0), now == Case::kLater ? 5U : self);
    }
  }
}

}  // namespace
}  // namespace tandem
