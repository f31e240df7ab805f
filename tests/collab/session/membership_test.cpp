#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collab/receive/peer_inbox.h"
#include "collab/session/peer_directory.h"
#include "engine/contact/pair/tangent_plane.h"

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

PeerInfo Anna() {
  PeerInfo info;
  info.peer = 2;
  info.name = "Anna";
  info.scene_hash = 42;
  info.claims = {{1, 4, true}};
  return info;
}

TEST(PeerDirectory, ReportsJoinLeaveLossAndReturnOnce) {
  PeerDirectory directory(1, 42);
  directory.OnPeerInfo(Anna());
  directory.OnPeerInfo(Anna());
  EXPECT_THAT(directory.TakeNotifications(), ElementsAre("Anna joined"));
  directory.OnPeerLost(2);
  directory.OnPeerLost(2);
  directory.OnPeerInfo(Anna());
  directory.OnPeerLeft(2);
  EXPECT_THAT(directory.TakeNotifications(),
              ElementsAre("Anna is lost", "Anna is back", "Anna left"));
  EXPECT_THAT(directory.TakeNotifications(), IsEmpty());
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
  // a belief in an authority is nothing new about what a peer holds
  other_hand.beliefs = {{3, 9}};
  directory.OnPeerInfo(other_hand);
  ASSERT_TRUE(directory.changes().TryPop(change));
  EXPECT_EQ(change.kind, MembershipChange::Kind::kBeliefs);
  EXPECT_EQ(change.claims[0].object, 5U);
  ASSERT_EQ(change.belief_count, 1U);
  EXPECT_EQ(change.beliefs[0], (Belief{3, 9}));
  directory.OnPeerInfo(other_hand);
  EXPECT_FALSE(directory.changes().TryPop(change));
  directory.OnPeerLost(2);
  ASSERT_TRUE(directory.changes().TryPop(change));
  EXPECT_EQ(change.kind, MembershipChange::Kind::kLost);
}

/// Makes the queue to a haptic thread that stands run full; the last change is one of claims.
void FillQueue(PeerDirectory& directory) {
  PeerInfo anna = Anna();
  for (std::uint32_t i = 0; i < 1000; ++i) {
    anna.claims[0].epoch = 4 + i;
    directory.OnPeerInfo(anna);
  }
}

/// Returns what waits in the queue.
std::vector<MembershipChange> Drain(PeerDirectory& directory) {
  std::vector<MembershipChange> changes;
  for (MembershipChange change; directory.changes().TryPop(change);) changes.push_back(change);
  return changes;
}

TEST(PeerDirectory, DeliversADeferredLeave) {
  PeerDirectory directory(1, 42);
  FillQueue(directory);
  directory.OnPeerLeft(2);
  directory.NotifyOwed();
  for (const MembershipChange& change : Drain(directory)) EXPECT_TRUE(change.present());
  directory.NotifyOwed();
  const std::vector<MembershipChange> owed = Drain(directory);
  ASSERT_THAT(owed, SizeIs(1));
  EXPECT_EQ(owed[0].kind, MembershipChange::Kind::kLeft);
  directory.NotifyOwed();
  EXPECT_THAT(Drain(directory), IsEmpty());
}

TEST(PeerDirectory, DeliversTheNewestDeferredClaims) {
  PeerDirectory directory(1, 42);
  FillQueue(directory);
  Drain(directory);
  directory.NotifyOwed();
  const std::vector<MembershipChange> owed = Drain(directory);
  ASSERT_THAT(owed, SizeIs(1));
  EXPECT_EQ(owed[0].kind, MembershipChange::Kind::kClaims);
  EXPECT_EQ(owed[0].claims[0].epoch, 1003U);
}

TEST(PeerDirectory, DeliversADeferredLeaveBeforeTheRejoin) {
  PeerDirectory directory(1, 42);
  FillQueue(directory);
  directory.OnPeerLeft(2);
  PeerInfo again = Anna();
  again.incarnation = 9;
  directory.OnPeerInfo(again);
  Drain(directory);
  directory.NotifyOwed();
  const std::vector<MembershipChange> owed = Drain(directory);
  ASSERT_THAT(owed, SizeIs(2));
  EXPECT_EQ(owed[0].kind, MembershipChange::Kind::kLeft);
  EXPECT_EQ(owed[1].kind, MembershipChange::Kind::kJoined);
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
  EXPECT_THAT(directory.TakeNotifications(), ElementsAre("Anna (viewer) joined", "Anna is lost"));
}

TEST(PeerDirectory, RefusesOtherScenesAndProtocolsInOneLine) {
  PeerDirectory directory(1, 41);
  directory.OnPeerInfo(Anna());
  PeerInfo newer = Anna();
  newer.peer = 3;
  newer.name = "Ben";
  newer.protocol = kProtocol + 1;
  directory.OnPeerInfo(newer);
  EXPECT_THAT(directory.TakeNotifications(),
              ElementsAre(HasSubstr("Anna is not accepted: its scene is"),
                          HasSubstr("Ben is not accepted: it uses protocol " +
                                    std::to_string(kProtocol + 1))));
  MembershipChange change;
  EXPECT_FALSE(directory.changes().TryPop(change));
}

TEST(PeerDirectory, DistinguishesPeersOfEqualNames) {
  PeerDirectory directory(1, 42, "Ben");
  PeerInfo info = Anna();
  directory.OnPeerInfo(info);
  info.peer = 3;
  directory.OnPeerInfo(info);
  info.name = "Ben";
  info.peer = 4;
  directory.OnPeerInfo(info);
  EXPECT_THAT(directory.TakeNotifications(),
              ElementsAre("Anna joined", "another Anna joined, shown as Anna (2)",
                          "another Ben joined, shown as Ben (2)"));
  EXPECT_EQ(directory.PeerNamed("Anna"), 2U);
  EXPECT_EQ(directory.PeerNamed("Anna (2)"), 3U);
  EXPECT_EQ(directory.NameOf(4), "Ben (2)");
  directory.OnPeerLost(3);
  EXPECT_THAT(directory.TakeNotifications(), ElementsAre("Anna (2) is lost"));
}

// Each time the same person comes back, with a new id. Nobody else has the name.
TEST(PeerDirectory, KeepsOneEntryForAPersonWhoComesAndGoes) {
  PeerDirectory directory(1, 42, "Ben");
  PeerInfo info = Anna();
  for (PeerId id = 2; id < 12; ++id) {
    info.peer = id;
    info.role = id % 2 == 0 ? Role::kViewer : Role::kActive;
    directory.OnPeerInfo(info);
    EXPECT_EQ(directory.NameOf(id), "Anna") << id;
    EXPECT_EQ(directory.Entries().size(), 1U) << id;
    if (id % 3 == 0) {
      directory.OnPeerLost(id);
    } else {
      directory.OnPeerLeft(id);
    }
    for (MembershipChange change; directory.changes().TryPop(change);) continue;
  }
}

// Her program crashes and is started again before anybody notices. A second Anna who speaks after
// the newcomer came is another person, and keeps her name.
TEST(PeerDirectory, NewProgramOfAPersonGetsTheNameOfTheCrashedOne) {
  PeerDirectory directory(1, 42, "Ben");
  PeerInfo crashed = Anna();
  directory.OnPeerInfo(crashed);
  PeerInfo again = Anna();
  again.peer = 3;
  directory.OnPeerInfo(again);
  EXPECT_EQ(directory.NameOf(3), "Anna (2)");
  directory.OnPeerLost(2);
  EXPECT_EQ(directory.NameOf(3), "Anna");
  EXPECT_THAT(directory.TakeNotifications(),
              ElementsAre("Anna joined", "another Anna joined, shown as Anna (2)", "Anna is lost",
                          "Anna (2) is shown as Anna from now on"));
  PeerInfo other = Anna();
  other.peer = 4;
  directory.OnPeerInfo(other);
  directory.OnPeerInfo(again);
  directory.OnPeerLost(3);
  EXPECT_EQ(directory.NameOf(4), "Anna (2)");
}

TEST(PeerDirectory, WhoLooksOnAndTakesPartHasOneName) {
  PeerDirectory directory(1, 42, "Ben");
  PeerInfo info = Anna();
  directory.OnPeerInfo(info);
  info.peer = 3;
  info.role = Role::kViewer;
  directory.OnPeerInfo(info);
  info.peer = 4;
  info.name = "Ben";
  directory.OnPeerInfo(info);
  EXPECT_EQ(directory.NameOf(3), "Anna");
  EXPECT_EQ(directory.NameOf(4), "Ben");
}

TEST(PeerDirectory, TellsThatAPeerStoppedItsHandAndGoesOn) {
  PeerDirectory directory(1, 42);
  PeerInfo info = Anna();
  directory.OnPeerInfo(info);
  info.stopped = true;
  directory.OnPeerInfo(info);
  directory.OnPeerInfo(info);
  info.stopped = false;
  directory.OnPeerInfo(info);
  EXPECT_THAT(directory.TakeNotifications(),
              ElementsAre("Anna joined", "Anna stopped: its hand holds and takes nothing",
                          "Anna goes on after a stop"));
}

TEST(PeerDirectory, KeepsFewOfTenThousandForgedParticipants) {
  PeerDirectory directory(1, 42);
  PeerInfo info = Anna();
  info.role = Role::kViewer;
  for (PeerId id = 2; id < 10'002; ++id) {
    info.peer = id;
    info.name = "forged " + std::to_string(id);
    directory.OnPeerInfo(info);
  }
  EXPECT_EQ(directory.Entries().size(), PeerDirectory::kMost);
  const std::vector<std::string> news = directory.TakeNotifications();
  EXPECT_EQ(news.size(), PeerDirectory::kMost + 1);
  EXPECT_THAT(news.back(), HasSubstr("this program ignores further ones"));
}

TEST(PeerDirectory, ForgetsTheLongestDepartedPeersAndUnreadLines) {
  PeerDirectory directory(1, 42);
  PeerInfo info = Anna();
  info.role = Role::kViewer;
  for (PeerId id = 2; id < 10'002; ++id) {
    info.peer = id;
    info.name = "viewer " + std::to_string(id);
    directory.OnPeerInfo(info);
    directory.OnPeerLeft(id);
  }
  EXPECT_EQ(directory.Entries().size(), PeerDirectory::kMost);
  EXPECT_EQ(directory.NameOf(10'001), "viewer 10001");
  EXPECT_EQ(directory.NameOf(2), "somebody");
  const std::vector<std::string> news = directory.TakeNotifications();
  EXPECT_EQ(news.size(), PeerDirectory::kMostNews + 1);
  EXPECT_EQ(news.back(), "and 19744 more such lines");  // 2 x 10,000 less 256
}

// The scene's body 1 is shared; Anna holds it and her own body 5, by other voxels than ours.
TEST(PeerDirectory, IgnoresSharedBodiesOfPeersWithOtherParameters) {
  OwnTerms terms{.parameters = {.voxel_size = 0.001}, .heaviest_kg = 0.1, .shared = {1}};
  PeerDirectory directory(1, 42, "Ben", terms);
  SceneManifest offer;
  offer.offered_by = 2;
  offer.revision = SceneManifest::kOwnOnly;
  offer.voxel_size = 0.002;
  offer.contact_stiffness = LeastContactStiffness(0.002);
  offer.force_layer = 1;
  offer.contact_model = static_cast<std::uint8_t>(ContactModel::kRefined);
  PeerInfo info = Anna();
  info.claims = {{1, 4, true}, {5, 2, true}};
  info.params_hash = HashOf(ParametersOf(offer));
  directory.OnPeerInfo(info);
  MembershipChange change;
  ASSERT_TRUE(directory.changes().TryPop(change));
  EXPECT_FALSE(change.Holds(1));
  EXPECT_TRUE(change.Holds(5));
  directory.OnScene(offer);
  directory.OnPeerInfo(info);
  directory.OnScene(offer);
  EXPECT_THAT(directory.TakeNotifications(),
              ElementsAre("Anna joined", HasSubstr("you push harder")));

  // once she goes by ours she is met in full
  info.params_hash = HashOf(terms.parameters);
  info.claims[0].epoch = 5;
  directory.OnPeerInfo(info);
  ASSERT_TRUE(directory.changes().TryPop(change));
  EXPECT_TRUE(change.Holds(1));
}

TEST(PeerDirectory, ExcludesItself) {
  PeerDirectory directory(2, 42);
  directory.OnPeerInfo(Anna());
  EXPECT_THAT(directory.Entries(), IsEmpty());
}

// The program is started again before anybody notices that it was gone. What was heard of the run
// before does not count.
TEST(PeerDirectory, RestartIsALossAndAJoin) {
  PeerDirectory directory(1, 42);
  PeerInfo info = Anna();
  info.incarnation = 5;
  directory.OnPeerInfo(info);
  info.incarnation = 6;
  directory.OnPeerInfo(info);
  std::vector<MembershipChange::Kind> kinds;
  for (MembershipChange change; directory.changes().TryPop(change);) kinds.push_back(change.kind);
  using Change = MembershipChange::Kind;
  EXPECT_EQ(kinds, (std::vector<Change>{Change::kJoined, Change::kLost, Change::kJoined}));
}

// Its bodies would stay its own for ever, because the hand would never hear that it has gone.
TEST(PeerDirectory, PeerThatBecomesAViewerLeavesTheHapticThread) {
  using Change = MembershipChange::Kind;
  PeerDirectory directory(1, 42);
  std::vector<Change> reported;
  const auto hear = [&](const PeerInfo& info) {
    directory.OnPeerInfo(info);
    MembershipChange change;
    while (directory.changes().TryPop(change)) reported.push_back(change.kind);
  };
  hear(Anna());
  PeerInfo looks_on = Anna();
  looks_on.role = Role::kViewer;
  hear(looks_on);
  hear(looks_on);
  hear(Anna());
  PeerInfo elsewhere = Anna();
  elsewhere.scene_hash = 43;
  hear(elsewhere);
  directory.OnPeerLeft(2);
  MembershipChange change;
  EXPECT_FALSE(directory.changes().TryPop(change));
  EXPECT_THAT(reported, ElementsAre(Change::kJoined, Change::kLost, Change::kBack, Change::kLost));
}

// A scene with the hash of another is made in a second.
TEST(PeerDirectory, SceneOfTheSameHashAndAnotherDigestIsAnotherScene) {
  PeerDirectory directory(1, 42, {}, {.scene_digest = {0xAB}, .parameters = {}, .shared = {}});
  PeerInfo honest = Anna();
  honest.scene_digest = {0xAB};
  honest.params_hash = HashOf(ForceParameters{});
  directory.OnPeerInfo(honest);
  EXPECT_THAT(directory.TakeNotifications(), ElementsAre("Anna joined"));
  PeerInfo forged = honest;
  forged.peer = 3;
  forged.name = "Mallory";
  forged.scene_digest = {0xAC};
  PeerInfo silent = forged;
  silent.peer = 4;
  silent.scene_digest = {};
  directory.OnPeerInfo(forged);
  directory.OnPeerInfo(silent);
  EXPECT_THAT(directory.TakeNotifications(),
              ElementsAre("Mallory is not accepted: its scene is ac00000000000000 and ours "
                          "ab00000000000000: open the same scene with the same files",
                          HasSubstr("its scene is 0000000000000000 and ours ab00000000000000")));
  for (const PeerDirectory::Entry& entry : directory.Entries()) {
    EXPECT_EQ(entry.refused.empty(), entry.info.peer == 2) << entry.info.peer;
  }
}

TEST(PeerDirectory, ParameterDifferencesAreReportedOnChange) {
  PeerDirectory directory(1, 42);
  directory.SetOwnTerms({.law = "p+dd", .gains = {}});
  PeerInfo info = Anna();
  info.terms = {.law = "constant", .gains = "stiffness=80", .contact = false};
  directory.OnPeerInfo(info);
  directory.OnPeerInfo(info);
  std::vector<std::string> news = directory.TakeNotifications();
  ASSERT_EQ(news.size(), 2U);
  EXPECT_EQ(news[1], info.name +
                         " uses other force terms: law constant (here p+dd), stiffness=80 (here "
                         "the law's own gains), no contact (here contact)");
  directory.SetOwnTerms({.law = "p+dd", .gains = {}, .displacement = 0.5e-3});
  news = directory.TakeNotifications();
  ASSERT_EQ(news.size(), 1U);
  EXPECT_NE(news[0].find("points displaced by 0 mm (here 0.5 mm)"), std::string::npos) << news[0];
  info.terms = {.law = "p+dd", .gains = {}, .displacement = 0.5e-3};
  directory.OnPeerInfo(info);
  EXPECT_EQ(directory.TakeNotifications(),
            std::vector<std::string>{info.name + " now uses the same force terms as you"});
}

TEST(PeerDirectory, EachRefusalIsReportedOnce) {
  PeerDirectory directory(1, 42);
  directory.OnPeerInfo(Anna());
  directory.TakeNotifications();
  DropTable drops;
  for (int i = 0; i < 1000; ++i) {
    drops.Count(Anna().peer, Drop::kSeized);
    drops.Count(Anna().peer, Drop::kWrongEpoch);  // a few of each hand-over: not told
    directory.NotifyRefusals(drops);
  }
  EXPECT_EQ(directory.TakeNotifications(),
            std::vector<std::string>{
                Anna().name + " claims bodies that others have and have not given away: refused"});
}

TEST(PeerDirectory, FewExcessSamplesAreTolerated) {
  PeerDirectory directory(1, 42);
  DropTable drops;
  for (std::uint64_t i = 1; i < TellFrom(Drop::kFlood); ++i) drops.Count(7, Drop::kFlood);
  directory.NotifyRefusals(drops);
  EXPECT_THAT(directory.TakeNotifications(), IsEmpty());
  drops.Count(7, Drop::kFlood);
  directory.NotifyRefusals(drops);
  EXPECT_THAT(directory.TakeNotifications(), SizeIs(1));
}

TEST(PeerDirectory, RefusedForgedPeersTakeNoMemory) {
  PeerDirectory directory(1, 42);
  DropTable drops;
  std::size_t lines = 0;
  for (PeerId peer = 2; peer <= 1000; ++peer) {
    for (int i = 0; i < 50; ++i) drops.Count(peer, Drop::kFlood);
    drops.Count(peer, Drop::kSeized);
    directory.NotifyRefusals(drops);
    lines += directory.TakeNotifications().size();
  }
  EXPECT_GT(lines, 1U);
  EXPECT_LE(lines, PeerDirectory::kMostRefusals);
}

}  // namespace
}  // namespace tandem
