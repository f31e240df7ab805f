#include <gtest/gtest.h>

#include "collab/ownership/ownership.h"
#include "tests/collab/ownership/ownership_cluster.h"

namespace tandem {
namespace {

using testing::kOwn;
using testing::OwnershipCluster;
using testing::TwoBodies;
using Kind = MembershipChange::Kind;

TEST(OwnershipDisputes, PartitionsOfASessionAgreeAfterReconnecting) {
  OwnershipCluster cluster({3, 5, 9}, 5);
  cluster[9].Ask(kOwn);
  cluster.Run(4000);  // known for long enough to be more than the other part
  cluster.Sever(9);
  cluster.Run(400);
  EXPECT_EQ(cluster[9].authority(0), 9U);
  EXPECT_EQ(cluster[5].authority(0), 3U);
  cluster[5].Ask(kOwn);
  cluster.Run(50);
  EXPECT_EQ(cluster.Holders(0), (std::vector<PeerId>{5, 9})) << "each part goes on by itself";
  cluster.Rejoin(9);
  cluster.Run(50);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{5});
  EXPECT_EQ(cluster.Authority(0), 5U);
}

TEST(OwnershipDisputes, OnlyTheAuthoritysSamplesCount) {
  OwnershipCluster cluster({3, 5, 9}, 0);
  cluster[5].Ask(kOwn);
  cluster.Run(20);
  ObjectState state;
  state.peer = 5;
  state.object = kOwn;
  state.epoch = 1;
  EXPECT_TRUE(cluster[9].Accepts(state));
  state.epoch = 2;
  EXPECT_FALSE(cluster[9].Accepts(state));
  state.epoch = 1;
  state.peer = 3;
  EXPECT_FALSE(cluster[9].Accepts(state));
}

// A peer that has forged a claim, or whose counter was corrupted, does not mute the true holder for
// ever.
TEST(OwnershipDisputes, ClaimWithAFarFutureEpochIsIgnored) {
  OwnershipCluster cluster({3, 5}, 0);
  cluster[5].Ask(kOwn);
  cluster.Run(20);
  MembershipChange forged{.kind = Kind::kJoined, .peer = 7, .claim_count = 1};
  forged.claims[0] = {kOwn, 0xFFFFFFFF, true};
  cluster[3].OnMembership(forged);
  EXPECT_EQ(cluster[3].authority(0), 5U);
}

/// Returns the change by which Mallory comes with the claim that it holds kOwn under this epoch.
MembershipChange Forged(std::uint32_t epoch, Kind kind = Kind::kJoined) {
  MembershipChange forged{.kind = kind, .peer = 77, .claim_count = 1};
  forged.claims[0] = {kOwn, epoch, true};
  return forged;
}

TEST(OwnershipDisputes, HigherClaimOnAHeldBodyIsIgnored) {
  OwnershipCluster cluster({3, 5, 9}, 0);
  cluster[5].Ask(kOwn);
  cluster.Run(300);
  for (std::uint32_t epoch = 2; epoch < 2000; ++epoch) {
    for (const PeerId peer : {3U, 5U, 9U}) {
      cluster[peer].OnMembership(Forged(epoch, epoch == 2 ? Kind::kJoined : Kind::kClaims));
    }
    cluster.Run(1);
  }
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{5});
  EXPECT_EQ(cluster.Authority(0), 5U);
}

// Nobody believes the last epoch, and a body that nobody has claimed does not come to it either:
// counting on from there would wrap.
TEST(OwnershipDisputes, FirstClaimAtTheLastEpochIsIgnored) {
  OwnershipCluster cluster({3, 5}, 0);
  cluster.Run(10);
  for (const PeerId peer : {3U, 5U}) cluster[peer].OnMembership(Forged(0xFFFFFFFF));
  cluster.Run(10);
  for (const PeerId peer : {3U, 5U}) {
    cluster[peer].OnMembership({.kind = Kind::kLeft, .peer = 77});
  }
  cluster.Run(10);
  cluster[5].Ask(kOwn);
  cluster.Run(50);
  cluster[3].Ask(kOwn);
  cluster.Run(50);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{5});
  EXPECT_EQ(cluster.Authority(0), 5U);
  EXPECT_LT(cluster[3].epoch(0), 100U);
  EXPECT_EQ(cluster.doubles(), 0);
}

// By steps that are each allowed nobody comes far either. All together raise an epoch by a thousand
// and ten a second; a peer by itself by a hundred more and ten a second.
TEST(OwnershipDisputes, EpochsRiseNoFasterThanPeersCanGrab) {
  const WorldModel model = TwoBodies();
  DropTable drops;
  Ownership three(3, model, 0, false, &drops);
  std::array<Event, 8> out;
  std::size_t count = 0;
  std::int64_t now_ns = 1'000'000'000;
  three.Tick(now_ns, out, count);
  three.OnMembership(Forged(1));
  for (int i = 0; i < 10'000; ++i) {
    three.Tick(now_ns += 1'000'000, out, count);
    three.OnMembership(Forged(three.epoch(0) + 900, Kind::kClaims));
  }
  EXPECT_LE(three.epoch(0), 1U + 1000 + 100 + 2 * 10 * 10);
  EXPECT_GT(drops.CountsOf(77)[static_cast<std::size_t>(Drop::kEpochLeap)], 1000U);
}

TEST(OwnershipDisputes, OnlyTheAuthoritysGrantsAndRefusalsCount) {
  OwnershipCluster cluster({3, 5, 9}, 0);
  cluster[5].Ask(kOwn);
  cluster.Run(300);
  Event forged{
      .peer = 77, .kind = EventKind::kGrant, .object = kOwn, .epoch = 2, .to = 3, .X_WB = {}};
  for (const EventKind kind : {EventKind::kGrant, EventKind::kRelease}) {
    forged.kind = kind;
    for (const PeerId from : {77U, 9U}) {  // one who is not here, and a member
      forged.peer = from;
      for (const PeerId peer : {3U, 5U}) cluster[peer].OnEvent(forged);
    }
    cluster.Run(10);
    EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{5});
    EXPECT_EQ(cluster.Authority(0), 5U);
  }
  cluster[3].Ask(kOwn);
  cluster.Run(1);
  cluster[3].OnEvent({.peer = 9, .kind = EventKind::kRefuse, .object = kOwn, .to = 3, .X_WB = {}});
  EXPECT_EQ(cluster[3].wanted(), 0) << "5 was asked, not 9";
}

// Ben alone was cut off, and has the body that Anna went on to hold. Most of those here say that it
// is hers.
TEST(OwnershipDisputes, MajorityKeepsItsBodiesAfterACut) {
  OwnershipCluster cluster({3, 5, 9}, 5);
  cluster[5].Ask(kOwn);
  cluster.Run(100);
  ASSERT_EQ(cluster[5].held(), 0);
  cluster.Sever(9);
  cluster.Run(3000);
  cluster[9].Ask(kOwn);
  cluster.Run(3000);
  ASSERT_EQ(cluster.Holders(0), (std::vector<PeerId>{5, 9}));
  cluster.Rejoin(9);
  cluster.Run(100);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{5});
  EXPECT_EQ(cluster.Authority(0), 5U);
}

// Nobody but the authority raises its claim. The grants of an authority that is gone count in turn.
TEST(OwnershipDisputes, SuccessorsGrantCountsAfterTheAuthorityIsLost) {
  OwnershipCluster cluster({3, 5, 9}, 0);
  cluster[5].Ask(kOwn);
  cluster.Run(300);
  for (const PeerId peer : {3U, 5U, 9U}) {
    cluster[peer].OnMembership({.kind = Kind::kJoined, .peer = 77});
  }
  Event forged{.peer = 77, .kind = EventKind::kGrant, .object = kOwn, .epoch = 40, .X_WB = {}};
  for (const PeerId to : {3U, 5U, 9U}) {
    forged.to = to;
    for (const PeerId peer : {3U, 5U, 9U}) cluster[peer].OnEvent(forged);
    cluster.Run(10);
  }
  EXPECT_EQ(cluster[9].epoch(0), 1U);
  EXPECT_EQ(cluster.Authority(0), 5U);
  cluster.Kill(5);
  forged.to = 9;
  for (const PeerId peer : {3U, 9U}) cluster[peer].OnEvent(forged);
  cluster.Run(400);
  EXPECT_EQ(cluster.Authority(0), 3U) << "the lowest that is left";
  EXPECT_EQ(cluster[9].epoch(0), 2U);
}

// A newcomer hears the liar first, who says that it is far along, and then all the others. The
// names that they give are no hearsay once it has known them for a while.
TEST(OwnershipDisputes, MisledPeerReturnsToTheCommonlyNamedAuthority) {
  Ownership late(9, TwoBodies());
  std::array<Event, 8> out;
  std::size_t count = 0;
  std::int64_t now_ns = 1'000'000'000;
  late.Tick(now_ns, out, count);
  late.OnMembership(Forged(900));
  late.Tick(now_ns += 1'000'000, out, count);
  ASSERT_EQ(late.authority(0), 77U);
  MembershipChange honest{.kind = Kind::kJoined, .peer = 5, .claim_count = 1};
  honest.claims[0] = {kOwn, 3, true};
  late.OnMembership(honest);
  MembershipChange other{.kind = Kind::kJoined, .peer = 3, .belief_count = 1};
  other.beliefs[0] = {kOwn, 5};
  late.OnMembership(other);
  for (int ms = 0; ms < 7000; ++ms) late.Tick(now_ns += 1'000'000, out, count);
  EXPECT_EQ(late.authority(0), 5U);
  EXPECT_EQ(late.epoch(0), 3U);
}

// Nobody names yet the peer that was handed a body a moment ago. Names of the giver are old news,
// and no votes for a third peer.
TEST(OwnershipDisputes, RecentGrantIsNotOverriddenByAHigherClaim) {
  OwnershipCluster cluster({3, 5, 9}, 50);
  cluster[5].Ask(kOwn);
  cluster.Run(6000);
  cluster[5].Give(9);
  cluster.Run(52);
  ASSERT_EQ(cluster[9].held(), 0);
  for (const PeerId peer : {3U, 5U, 9U}) cluster[peer].OnMembership(Forged(40));
  cluster.Run(300);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{9});
  EXPECT_EQ(cluster.Authority(0), 9U);
}

// A peer that wakes up has missed things, but not what most of the others say that it has.
TEST(OwnershipDisputes, ResumedPeerKeepsBodiesThatOthersAttributeToIt) {
  OwnershipCluster cluster({3, 5, 9}, 0);
  cluster[9].Ask(kOwn);
  cluster.Run(2000);
  ASSERT_EQ(cluster.Holders(0), std::vector<PeerId>{9});
  cluster.Stop(9, true);
  cluster.Run(600);
  for (const PeerId peer : {3U, 5U, 9U}) cluster[peer].OnMembership(Forged(40));
  cluster.Stop(9, false);
  cluster.Run(300);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{9});
  EXPECT_EQ(cluster.Authority(0), 9U);
}

// The peers that name the giver have not heard of the gift yet, and the giver's claim is for what
// is no longer its own.
TEST(OwnershipDisputes, GiverCannotReclaimByAHigherEpoch) {
  OwnershipCluster cluster({3, 5, 77}, 50);
  cluster[77].Ask(kOwn);
  cluster.Run(6000);
  cluster[77].Give(5);
  cluster.Run(52);
  ASSERT_EQ(cluster[5].held(), 0);
  cluster[5].OnMembership(Forged(40, Kind::kClaims));
  cluster.Run(1);
  EXPECT_EQ(cluster[5].held(), 0);
}

// Two peers have it by the same epoch, and the one of the higher id yields after a while. Until
// then it does not claim above the other, or each would answer the other for ever.
TEST(OwnershipDisputes, YieldingPeerDoesNotRenewItsClaim) {
  OwnershipCluster cluster({3, 9}, 5);
  cluster.Sever(9);
  cluster.Run(2000);
  cluster[3].Ask(kOwn);
  cluster[9].Ask(kOwn);
  cluster.Run(3000);
  ASSERT_EQ(cluster.Holders(0), (std::vector<PeerId>{3, 9}));
  const std::uint32_t before = cluster[3].epoch(0);
  cluster.Rejoin(9);
  cluster.Run(300);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{3});
  EXPECT_LE(cluster[3].epoch(0), before + 2);
}

// The peer that answers for the body goes, and all who stay have heard already to whom it gave the
// body.
TEST(OwnershipDisputes, UnanimouslyNamedPeerTakesOverAtOnce) {
  Ownership high(9, TwoBodies());
  std::array<Event, 8> out;
  std::size_t count = 0;
  std::int64_t now_ns = 1'000'000'000;
  high.Tick(now_ns, out, count);
  high.OnMembership(Forged(4));
  high.Tick(now_ns += 1'000'000, out, count);
  ASSERT_EQ(high.authority(0), 77U);
  MembershipChange low{.kind = Kind::kJoined, .peer = 3, .belief_count = 1};
  low.beliefs[0] = {kOwn, 9, 3};
  high.OnMembership(low);
  high.OnMembership({.kind = Kind::kLeft, .peer = 77});
  for (int ms = 0; ms < 10; ++ms) high.Tick(now_ns += 1'000'000, out, count);
  EXPECT_EQ(high.authority(0), 9U);
}

// A peer that has been here for long could believe more than one that has just come, and would
// count on from there out of the newcomer's sight.
TEST(OwnershipDisputes, LongPresentPeerAcceptsNoMoreThanANewcomer) {
  Ownership old(5, TwoBodies());
  Ownership young(3, TwoBodies());
  std::array<Event, 8> out;
  std::size_t count = 0;
  std::int64_t now_ns = 1'000'000'000;
  old.Tick(now_ns, out, count);
  old.Ask(kOwn);
  for (int i = 0; i < 2000; ++i) old.Tick(now_ns += 400'000'000, out, count);
  ASSERT_EQ(old.held(), 0);
  young.Tick(now_ns, out, count);
  old.OnMembership({.kind = Kind::kJoined, .peer = 3});
  const auto hear_old = [&](Kind kind) {
    MembershipChange change{.kind = kind, .peer = 5};
    change.claim_count = old.Claims(change.claims);
    young.OnMembership(change);
    young.Tick(now_ns, out, count);
  };
  hear_old(Kind::kJoined);
  for (const std::uint32_t epoch : {900U, 3000U, 7000U}) {
    old.OnMembership(Forged(epoch));
    for (int i = 0; i < 5; ++i) old.Tick(now_ns += 400'000'000, out, count);
    hear_old(Kind::kClaims);
    EXPECT_EQ(young.authority(0), 5U) << epoch;
    EXPECT_EQ(young.epoch(0), old.epoch(0)) << epoch;
  }
  EXPECT_LT(old.epoch(0), 1000U);
}

// The owner gave it to each by a word that the other did not hear, and is gone.
TEST(OwnershipDisputes, LowerOfTwoConnectedPeersKeepsAParkedBody) {
  OwnershipCluster cluster({3, 5}, 100);
  for (const PeerId peer : {3U, 5U}) cluster[peer].OnMembership(Forged(1));
  cluster.Run(6000);
  ASSERT_EQ(cluster.Authority(0), 77U);
  for (const PeerId peer : {3U, 5U}) {
    MembershipChange word{.kind = Kind::kClaims, .peer = 77, .belief_count = 1};
    word.beliefs[0] = {kOwn, peer, static_cast<std::uint32_t>(peer)};
    cluster[peer].OnMembership(word);
  }
  cluster.Run(1);
  ASSERT_EQ(cluster[3].authority(0), 3U);
  ASSERT_EQ(cluster[5].authority(0), 5U);
  for (const PeerId peer : {3U, 5U}) {
    cluster[peer].OnMembership({.kind = Kind::kLost, .peer = 77});
  }
  cluster.Run(6000);
  EXPECT_EQ(cluster.Authority(0), 3U);
}

// Ten grabs a second are as many as people do: after an hour apart 36,000 more are believed.
TEST(OwnershipDisputes, TransfersDuringALongCutAreAccepted) {
  Ownership cut_off(3, TwoBodies());
  MembershipChange change{.kind = Kind::kJoined, .peer = 5, .claim_count = 1};
  std::array<Event, 8> out;
  std::size_t count = 0;
  cut_off.Tick(1'000'000'000, out, count);
  change.claims[0] = {kOwn, 1, true};
  cut_off.OnMembership(change);
  cut_off.Settle();
  cut_off.OnMembership({.kind = Kind::kLost, .peer = 5});
  cut_off.Tick(3'601'000'000'000, out, count);
  change.kind = Kind::kBack;
  change.claims[0].epoch = 36'000;
  cut_off.OnMembership(change);
  EXPECT_EQ(cut_off.epoch(0), 36'000U);
  EXPECT_EQ(cut_off.authority(0), 5U);
}

}  // namespace
}  // namespace tandem
