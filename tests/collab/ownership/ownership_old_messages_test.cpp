// Tests that words from before a body changed hands, or of an earlier run, move it no more.
#include <gtest/gtest.h>

#include "tests/collab/ownership/listener.h"

namespace tandem {
namespace {

using testing::kLiar;
using testing::kOwn;
using testing::Listener;
using Kind = MembershipChange::Kind;

// The peer that is granted a body says for a while that the granter has it. The granter does not
// get it back by that word.
TEST(OwnershipMisled, OutdatedReportOfTheNewAuthorityDoesNotUndoAGrant) {
  Listener three(3);
  three.HearClaim(kLiar, 1, false, Kind::kJoined);
  three.HearName(5, kLiar, 1, Kind::kJoined);
  three.Run(6000);
  three.HearName(kLiar, 5, 2);
  three.Run(1);
  ASSERT_EQ(three.ownership().authority(0), 5U);
  three.HearClaim(kLiar, 4, false);
  three.Run(10);
  EXPECT_EQ(three.ownership().authority(0), 5U);
  EXPECT_EQ(three.ownership().epoch(0), 2U);
}

TEST(OwnershipMisled, LeavingPeerGivesUpItsBodies) {
  Listener three(3);
  three.HearClaim(kLiar, 4, false, Kind::kJoined);
  three.HearName(5, kLiar, 4, Kind::kJoined);
  three.Run(6000);
  three.HearGone(kLiar, Kind::kLeft);
  three.ownership().Ask(kOwn);
  three.Run(2);
  ASSERT_EQ(three.ownership().held(), 0);
  three.HearClaim(kLiar, 7, true, Kind::kBack);
  three.Run(20);
  EXPECT_EQ(three.ownership().held(), 0) << "5 names the liar since it has not heard yet";
}

// 5 took the body over and granted it. 9 has not heard of either.
TEST(OwnershipMisled, OutdatedReportsDoNotTakeAHeldBody) {
  Listener three(3);
  three.HearClaim(kLiar, 4, false, Kind::kJoined);
  three.HearName(5, kLiar, 4, Kind::kJoined);
  three.HearName(9, kLiar, 4, Kind::kJoined);
  three.Run(6000);
  three.HearGone(kLiar, Kind::kLost);
  three.Run(100);
  three.HearClaim(5, 5, false);
  three.Run(300);
  ASSERT_EQ(three.ownership().authority(0), 5U);
  three.ownership().Ask(kOwn);
  three.Run(1);
  three.HearGrant(5, 3, 6);
  three.Run(1);
  ASSERT_EQ(three.ownership().held(), 0);
  three.HearClaim(kLiar, 7, false, Kind::kBack);
  three.Run(50);
  EXPECT_EQ(three.ownership().held(), 0);
  three.HearName(5, 3, 6);
  three.HearName(9, 3, 6);
  three.Run(6000);
  EXPECT_EQ(three.ownership().held(), 0);
}

// 9 gave the body to 3, which left before it had it. 7 has not heard of the gift and is the next in
// line.
TEST(OwnershipMisled, OutdatedReportDoesNotReturnAGivenBody) {
  Listener nine(9);
  nine.HearClaim(3, 1, false, Kind::kJoined);
  nine.HearName(7, 3, 1, Kind::kJoined);
  nine.Run(6000);
  nine.ownership().Ask(kOwn);
  nine.Run(1);
  nine.HearGrant(3, 9, 2);
  nine.HearName(3, 9, 2);
  nine.HearName(7, 9, 2);
  nine.Run(1);
  ASSERT_EQ(nine.ownership().held(), 0);
  nine.ownership().Give(3);
  nine.Run(1);
  nine.HearGone(3, Kind::kLeft);
  nine.Run(1000);
  EXPECT_EQ(nine.ownership().authority(0), 3U);
  nine.HearClaim(7, 4, false);
  nine.Run(1);
  EXPECT_EQ(nine.ownership().authority(0), 7U);
}

// 5 took the body over while the liar was lost, and this peer hears of that only when the liar is
// here again (hostile seed 720).
TEST(OwnershipMisled, RestartedAuthorityHasNothingToGive) {
  for (const Kind gone : {Kind::kLost, Kind::kLeft}) {
    Listener nine(9);
    nine.HearClaim(kLiar, 1, false, Kind::kJoined);
    nine.HearName(5, kLiar, 1, Kind::kJoined);
    nine.Run(6000);
    nine.HearGone(kLiar, gone);
    nine.Run(100);
    nine.HearName(kLiar, kLiar, 1, Kind::kJoined);
    nine.Run(1);
    nine.HearClaim(kLiar, 2, false);
    nine.HearGrant(kLiar, 9, 2);
    nine.HearName(kLiar, 9, 3);
    nine.Run(10);
    EXPECT_EQ(nine.ownership().authority(0), kLiar);
    EXPECT_EQ(nine.ownership().held(), -1);
    nine.HearClaim(5, 2, false);
    nine.Run(1);
    EXPECT_EQ(nine.ownership().authority(0), 5U);
    nine.HearClaim(kLiar, 4, true);
    nine.Run(1000);
    EXPECT_EQ(nine.ownership().authority(0), 5U);
  }
}

TEST(OwnershipMisled, BodyOfARestartedPeerIsTakenOver) {
  Listener three(3);
  three.HearClaim(5, 1, true, Kind::kJoined);
  three.Run(6000);
  three.HearGone(5, Kind::kLost);
  three.HearGone(5, Kind::kJoined);
  three.Run(290);
  EXPECT_EQ(three.ownership().authority(0), 5U);
  three.Run(20);
  EXPECT_EQ(three.ownership().authority(0), 3U);
}

// The liar gave the body to 3 and started anew; 5 and 9 have not heard of the gift (hostile seeds
// 718 and 905).
TEST(OwnershipMisled, RestartedGiverDoesNotReclaimByOutdatedReports) {
  Listener three(3);
  three.HearClaim(kLiar, 4, false, Kind::kJoined);
  three.HearName(5, kLiar, 4, Kind::kJoined);
  three.HearName(9, kLiar, 4, Kind::kJoined);
  three.Run(6000);
  three.Hear(EventKind::kRelease, kLiar, 3, 5);
  three.Run(500);
  ASSERT_EQ(three.ownership().authority(0), 3U);
  three.HearGone(kLiar, Kind::kLost);
  three.HearClaim(kLiar, 7, false, Kind::kJoined);
  three.Run(2000);
  EXPECT_EQ(three.ownership().authority(0), 3U);
}

// This peer had the body by the liar's word once, gave it away, and took it over as 5 was lost
// (hostile seed 114).
TEST(OwnershipMisled, OutdatedGrantDoesNotUndoATakeover) {
  for (const EventKind kind : {EventKind::kGrant, EventKind::kRelease}) {
    Listener three(3);
    three.HearClaim(kLiar, 1, false, Kind::kJoined);
    three.HearName(5, kLiar, 1, Kind::kJoined);
    three.Run(6000);
    three.HearName(kLiar, 3, 2);
    three.Run(1);
    ASSERT_EQ(three.ownership().authority(0), 3U);
    three.Hear(EventKind::kAsk, 5, 3, 2);
    three.HearClaim(5, 3, false);
    three.Run(1);
    ASSERT_EQ(three.ownership().authority(0), 5U);
    three.HearGone(5, Kind::kLost);
    three.Run(400);
    ASSERT_EQ(three.ownership().authority(0), 3U);
    three.Hear(kind, kLiar, 3, three.ownership().epoch(0));
    three.Run(1);
    EXPECT_EQ(three.ownership().ParkedAt(0), nullptr);
    EXPECT_EQ(three.ownership().held(), -1);
  }
}

// The epoch that the liar has this peer rise to is not that of a grant that is on its way.
TEST(OwnershipMisled, GrantUnderAnEpochRaisedByNamesIsNotTheAwaitedOne) {
  Listener three(3);
  three.HearClaim(kLiar, 1, false, Kind::kJoined);
  three.Run(6000);
  three.HearName(kLiar, 3, 2);
  three.Run(1);
  three.HearName(kLiar, 3, 9);
  three.Run(1);
  ASSERT_EQ(three.ownership().epoch(0), 9U);
  three.Hear(EventKind::kRelease, kLiar, 3, 9);
  EXPECT_EQ(three.ownership().ParkedAt(0), nullptr);
  three.Hear(EventKind::kRelease, kLiar, 3, 2);
  EXPECT_EQ(three.ownership().ParkedAt(0), nullptr) << "as it has been: it is where it is here";
}

}  // namespace
}  // namespace tandem
