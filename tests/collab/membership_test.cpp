#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collab/peer_directory.h"
#include "collab/peer_inbox.h"

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

PeerInfo Anna() {
  PeerInfo info;
  info.peer = 2;
  info.name = "Anna";
  info.scene_hash = 42;
  info.claims = {{1, 4, true}};
  return info;
}

TEST(PeerDirectory, TellsOfJoiningLeavingLossAndReturnOnceEach) {
  PeerDirectory directory(1, 42);
  directory.OnPeerInfo(Anna());
  directory.OnPeerInfo(Anna());
  EXPECT_THAT(directory.TakeNews(), ElementsAre("Anna joined"));
  directory.OnPeerLost(2);
  directory.OnPeerLost(2);
  directory.OnPeerInfo(Anna());
  directory.OnPeerLeft(2);
  EXPECT_THAT(directory.TakeNews(), ElementsAre("Anna is lost", "Anna is back", "Anna left"));
  EXPECT_THAT(directory.TakeNews(), IsEmpty());
}

TEST(PeerDirectory, HandsChangesToTheHapticThread) {
  PeerDirectory directory(1, 42);
  MembershipChange change;
  EXPECT_FALSE(directory.changes().TryPop(change));
  directory.OnPeerInfo(Anna());
  ASSERT_TRUE(directory.changes().TryPop(change));
  EXPECT_EQ(change.peer, 2U);
  EXPECT_EQ(change.kind, MembershipChange::Kind::kJoined);
  ASSERT_EQ(change.claim_count, 1U);
  EXPECT_EQ(change.claims[0], (Claim{1, 4, true}));
  PeerInfo other_hand = Anna();
  other_hand.claims = {{5, 1, true}};
  directory.OnPeerInfo(other_hand);
  ASSERT_TRUE(directory.changes().TryPop(change));
  EXPECT_EQ(change.kind, MembershipChange::Kind::kClaims);
  EXPECT_EQ(change.claims[0].object, 5U);
  directory.OnPeerLost(2);
  ASSERT_TRUE(directory.changes().TryPop(change));
  EXPECT_EQ(change.kind, MembershipChange::Kind::kLost);
}

TEST(PeerDirectory, KeepsViewersFromTheHapticThread) {
  PeerDirectory directory(1, 42);
  PeerInfo viewer = Anna();
  viewer.role = Role::kViewer;
  viewer.scene_hash = 0;
  directory.OnPeerInfo(viewer);
  directory.OnPeerLost(2);
  MembershipChange change;
  EXPECT_FALSE(directory.changes().TryPop(change));
  EXPECT_THAT(directory.TakeNews(), ElementsAre("Anna (viewer) joined", "Anna is lost"));
}

TEST(PeerDirectory, RefusesOtherScenesAndProtocolsInOneClearLine) {
  PeerDirectory directory(1, 41);
  directory.OnPeerInfo(Anna());
  PeerInfo newer = Anna();
  newer.peer = 3;
  newer.name = "Ben";
  newer.protocol = kProtocol + 1;
  directory.OnPeerInfo(newer);
  EXPECT_THAT(directory.TakeNews(),
              ElementsAre(HasSubstr("Anna is not taken in: its scene is"),
                          HasSubstr("Ben is not taken in: it speaks protocol 3")));
  MembershipChange change;
  EXPECT_FALSE(directory.changes().TryPop(change));
}

TEST(PeerDirectory, TellsPeersOfOneNameApart) {
  PeerDirectory directory(1, 42, "Ben");
  PeerInfo info = Anna();
  directory.OnPeerInfo(info);
  info.peer = 3;
  directory.OnPeerInfo(info);
  info.name = "Ben";
  info.peer = 4;
  directory.OnPeerInfo(info);
  EXPECT_THAT(directory.TakeNews(),
              ElementsAre("Anna joined", "another Anna joined, shown as Anna (2)",
                          "another Ben joined, shown as Ben (2)"));
  EXPECT_EQ(directory.PeerNamed("Anna"), 2U);
  EXPECT_EQ(directory.PeerNamed("Anna (2)"), 3U);
  EXPECT_EQ(directory.NameOf(4), "Ben (2)");
  directory.OnPeerLost(3);
  EXPECT_THAT(directory.TakeNews(), ElementsAre("Anna (2) is lost"));
}

TEST(PeerDirectory, IsNotItsOwnPeer) {
  PeerDirectory directory(2, 42);
  directory.OnPeerInfo(Anna());
  EXPECT_THAT(directory.Entries(), IsEmpty());
}

}  // namespace
}  // namespace tandem
