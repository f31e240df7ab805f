// Tests disputes about a body that several hands may hold at once.
#include <array>

#include <gtest/gtest.h>

#include "collab/ownership/ownership.h"
#include "tests/collab/ownership/ownership_cluster.h"

namespace tandem {
namespace {

using testing::kShared;
using testing::OwnershipCluster;
using testing::TwoBodies;
using Kind = MembershipChange::Kind;

// A peer that says it holds a body beside others could give it away, and put it into a third peer's
// hand.
TEST(OwnershipDisputes, SharedBodyIsLeftToItsHolders) {
  OwnershipCluster cluster({3, 5, 9}, 0);
  cluster[3].Ask(kShared);
  cluster.Run(10);
  cluster[5].Ask(kShared);
  cluster.Run(10);
  ASSERT_EQ(cluster.Authority(1), 3U);
  const std::uint32_t epoch = cluster[3].epoch(1);
  MembershipChange forged{.kind = Kind::kJoined, .peer = 77, .claim_count = 1};
  forged.claims[0] = {kShared, epoch, true};
  Event grant{.peer = 77,
              .seq = 1,
              .kind = EventKind::kGrant,
              .object = kShared,
              .epoch = epoch + 1,
              .to = 9,
              .X_WB = {}};
  Event release = grant;
  release.kind = EventKind::kRelease;
  for (const PeerId peer : {3U, 5U, 9U}) {
    cluster[peer].OnMembership(forged);
    cluster[peer].OnEvent(grant);
    cluster[peer].OnEvent(release);
  }
  cluster.Run(50);
  EXPECT_EQ(cluster.Authority(1), 3U);
  EXPECT_EQ(cluster[9].held(), -1);
}

/// Runs frames of 1 ms in which nothing is heard, and throws away what the peer says.
void RunAlone(Ownership& ownership, std::int64_t& now_ns, int frames) {
  std::array<Event, 8> out;
  std::size_t count = 0;
  for (int i = 0; i < frames; ++i) ownership.Tick(now_ns += 1'000'000, out, count);
}

/// Returns the change in which `peer` says of the shared body that it holds it, or that `owner`
/// answers for it.
MembershipChange Beside(PeerId peer, std::uint32_t epoch, bool held, PeerId owner,
                        Kind kind = Kind::kClaims) {
  MembershipChange stated{.kind = kind, .peer = peer};
  if (held) stated.claims[stated.claim_count++] = {kShared, epoch, true};
  if (owner != 0) stated.beliefs[stated.belief_count++] = {kShared, owner, epoch};
  return stated;
}

// The peer answered for the body, too, and handed it back under an epoch of its own, of which all
// others have heard.
TEST(OwnershipDisputes, BodyReturnedToItsHolderContinuesItsEpoch) {
  Ownership nine(9, TwoBodies());
  std::array<Event, 8> out;
  std::size_t count = 0;
  std::int64_t now_ns = 1'000'000'000;
  nine.Tick(now_ns, out, count);
  nine.OnMembership(Beside(3, 1, false, 0, Kind::kJoined));
  Event event{
      .peer = 3, .kind = EventKind::kGrant, .object = kShared, .epoch = 1, .to = 9, .X_WB = {}};
  nine.OnEvent(event);
  nine.Tick(now_ns += 1'000'000, out, count);
  ASSERT_EQ(nine.held(), 1);
  event.kind = EventKind::kRelease;
  event.epoch = 2;
  nine.OnEvent(event);
  EXPECT_EQ(nine.epoch(1), 2U);
  EXPECT_EQ(nine.held(), 1);
  event.epoch = 2000;
  nine.OnEvent(event);
  EXPECT_EQ(nine.epoch(1), 2U) << "no farther than anybody can grab";
}

// The lowest of the peers that hold it under one epoch answers, and another may have heard of that
// before we do.
TEST(OwnershipDisputes, NamedAuthorityOfASharedBodyMayClaimIt) {
  Ownership nine(9, TwoBodies());
  std::int64_t now_ns = 1'000'000'000;
  const auto run = [&](int frames) {
    RunAlone(nine, now_ns, frames);
  };
  run(1);
  for (const PeerId peer : {3, 5}) nine.OnMembership(Beside(peer, 1, false, 0, Kind::kJoined));
  nine.OnEvent(
      {.peer = 3, .kind = EventKind::kGrant, .object = kShared, .epoch = 1, .to = 9, .X_WB = {}});
  nine.Ask(kShared);
  run(2000);
  ASSERT_EQ(nine.held(), 1);
  for (const PeerId peer : {3, 5}) nine.OnMembership(Beside(peer, 1, false, 9));
  run(10);
  nine.OnMembership(Beside(5, 1, false, 3));
  run(100);
  EXPECT_EQ(nine.epoch(1), 1U);
  EXPECT_EQ(nine.authority(1), 9U);
  nine.OnMembership(Beside(3, 1, true, 0));
  run(1);
  EXPECT_EQ(nine.epoch(1), 1U);
  EXPECT_EQ(nine.authority(1), 3U);
}

TEST(OwnershipDisputes, ReceivedSharedBodyBelongsToTheLowestHolder) {
  Ownership nine(9, TwoBodies());
  std::int64_t now_ns = 1'000'000'000;
  const auto run = [&](int frames) {
    RunAlone(nine, now_ns, frames);
  };
  run(1);
  nine.OnMembership(Beside(3, 7, false, 5, Kind::kJoined));
  nine.OnMembership(Beside(5, 7, true, 0, Kind::kJoined));
  nine.Ask(kShared);
  run(6000);
  ASSERT_EQ(nine.held(), 1);
  ASSERT_EQ(nine.authority(1), 5U);
  // 5 has left it to us, and 3 took it beside us
  nine.OnMembership(Beside(3, 8, true, 0));
  run(1);
  nine.OnEvent(
      {.peer = 5, .kind = EventKind::kRelease, .object = kShared, .epoch = 8, .to = 9, .X_WB = {}});
  run(1);
  EXPECT_EQ(nine.authority(1), 3U);
  EXPECT_EQ(nine.epoch(1), 8U);
  EXPECT_EQ(nine.held(), 1);
}

}  // namespace
}  // namespace tandem
