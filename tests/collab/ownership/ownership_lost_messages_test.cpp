// Tests what becomes of a body when words of its grant or hand-over are lost.
#include <array>
#include <vector>

#include <gtest/gtest.h>

#include "collab/ownership/ownership.h"
#include "tests/collab/ownership/ownership_cluster.h"

namespace tandem {
namespace {

using testing::kOwn;
using testing::OwnershipCluster;
using testing::TwoBodies;
using Kind = MembershipChange::Kind;

TEST(Ownership, LostGrantIsRepeated) {
  OwnershipCluster cluster({3, 5}, 0);
  cluster.Run(5);
  // 3 has granted it to 5, which never heard of it
  Event ask;
  ask.peer = 5;
  ask.object = kOwn;
  ask.to = 3;
  cluster[3].OnEvent(ask);
  std::array<Event, 8> events;
  std::size_t count = 0;
  cluster[3].Tick(6'000'000, events, count);
  ASSERT_EQ(count, 1U);
  EXPECT_EQ(events[0].kind, EventKind::kGrant);
  cluster[5].Ask(kOwn);
  cluster.Run(20);
  EXPECT_EQ(cluster.Holders(0), std::vector<PeerId>{5});
  EXPECT_EQ(cluster.Authority(0), 5U);
}

/// Runs frames of 1 ms of one peer by itself, and returns the events of kind `kind` that it says.
std::vector<Event> EventsSent(Ownership& ownership, std::int64_t& now_ns, int frames,
                              EventKind kind) {
  std::vector<Event> stated;
  for (int i = 0; i < frames; ++i) {
    std::array<Event, 8> out;
    std::size_t count = 0;
    ownership.Tick(now_ns += 1'000'000, out, count);
    for (std::size_t e = 0; e < count; ++e) {
      if (out[e].kind == kind) stated.push_back(out[e]);
    }
  }
  return stated;
}

// The peer is granted a body and killed before it can say so. It counts as gone when it is lost,
// and the lowest goes first.
TEST(Ownership, SilentRecipientOfAGrantIsGoneOnlyOnceItIsLost) {
  const WorldModel model = TwoBodies();
  Ownership nine(9, model);
  std::int64_t now_ns = 1'000'000'000;
  for (const PeerId peer : {3, 5, 7}) nine.OnMembership({.kind = Kind::kJoined, .peer = peer});
  EventsSent(nine, now_ns, 10, EventKind::kGrant);
  nine.OnEvent(
      {.peer = 3, .kind = EventKind::kGrant, .object = kOwn, .epoch = 2, .to = 7, .X_WB = {}});
  EventsSent(nine, now_ns, 3000, EventKind::kGrant);
  ASSERT_EQ(nine.authority(0), 7U);
  nine.OnMembership({.kind = Kind::kLost, .peer = 7});
  EventsSent(nine, now_ns, 5000, EventKind::kGrant);
  EXPECT_EQ(nine.authority(0), 7U) << "3 and 5 are before us, two and a half seconds each";
  EventsSent(nine, now_ns, 400, EventKind::kGrant);
  EXPECT_EQ(nine.authority(0), 9U);
}

TEST(Ownership, LostHandoverIsRepeated) {
  const WorldModel model = TwoBodies();
  Ownership three(3, model);
  std::int64_t now_ns = 1'000'000'000;
  three.OnMembership({.kind = Kind::kJoined, .peer = 9});
  three.Ask(kOwn);
  EventsSent(three, now_ns, 10, EventKind::kGrant);
  ASSERT_EQ(three.held(), 0);
  three.Give(9);
  const std::vector<Event> stated = EventsSent(three, now_ns, 600, EventKind::kGrant);
  ASSERT_EQ(stated.size(), 3U);  // at once, and every 250 ms
  for (const Event& event : stated) {
    EXPECT_EQ(event.to, 9U);
    EXPECT_EQ(event.epoch, stated[0].epoch);
  }
  MembershipChange answer{.kind = Kind::kClaims, .peer = 9};
  answer.claim_count = 1;
  answer.claims[0] = {.object = kOwn, .epoch = stated[0].epoch, .held = true};
  three.OnMembership(answer);
  EXPECT_TRUE(EventsSent(three, now_ns, 1000, EventKind::kGrant).empty());
}

// Both ends of a grant crash, and the lowest peer left was cut off when it was made.
TEST(Ownership, MissedGrantIsPassedOnOnce) {
  const WorldModel model = TwoBodies();
  Ownership three(3, model);
  Ownership nine(9, model);
  std::int64_t now_ns = 1'000'000'000;
  const auto both = [&](Kind kind, PeerId peer) {
    if (peer != 3) three.OnMembership({.kind = kind, .peer = peer});
    if (peer != 9) nine.OnMembership({.kind = kind, .peer = peer});
  };
  for (const PeerId peer : {2, 3, 7, 9}) both(Kind::kJoined, peer);
  EventsSent(nine, now_ns, 10, EventKind::kGrant);
  nine.OnEvent(
      {.peer = 2, .kind = EventKind::kGrant, .object = kOwn, .epoch = 1, .to = 7, .X_WB = {}});
  EXPECT_TRUE(EventsSent(nine, now_ns, 100, EventKind::kGrant).empty());
  for (const PeerId peer : {2, 7}) both(Kind::kLost, peer);
  const std::vector<Event> stated = EventsSent(nine, now_ns, 100, EventKind::kGrant);
  ASSERT_EQ(stated.size(), 1U);
  three.OnEvent(stated[0]);
  EXPECT_TRUE(EventsSent(three, now_ns, 290, EventKind::kGrant).empty())
      << "nobody is before it in line";
  EXPECT_EQ(three.authority(0), 7U);
  EventsSent(three, now_ns, 20, EventKind::kGrant);
  EXPECT_EQ(three.authority(0), 3U);
  EXPECT_EQ(three.epoch(0), 2U);
  EXPECT_TRUE(EventsSent(nine, now_ns, 800, EventKind::kGrant).empty());
}

// It crashes with the body in hand and is back, its hand empty, before anybody took it for lost.
TEST(Ownership, CompletedHandoverIsNotRepeatedToARestartedPeer) {
  const WorldModel model = TwoBodies();
  Ownership three(3, model);
  std::int64_t now_ns = 1'000'000'000;
  three.OnMembership({.kind = Kind::kJoined, .peer = 9});
  three.Ask(kOwn);
  EventsSent(three, now_ns, 10, EventKind::kGrant);
  three.Give(9);
  ASSERT_EQ(EventsSent(three, now_ns, 10, EventKind::kGrant).size(), 1U);
  MembershipChange answer{.kind = Kind::kClaims, .peer = 9};
  answer.claim_count = 1;
  answer.claims[0] = {.object = kOwn, .epoch = three.epoch(0), .held = true};
  three.OnMembership(answer);
  EventsSent(three, now_ns, 10, EventKind::kGrant);
  three.OnMembership({.kind = Kind::kClaims, .peer = 9});
  EXPECT_TRUE(EventsSent(three, now_ns, 4000, EventKind::kGrant).empty());
  EventsSent(three, now_ns, 2000, EventKind::kGrant);
  EXPECT_EQ(three.authority(0), 3U) << "nobody answered for it for five seconds";
}

// The peer came as the authority crashed, and would not take over: nobody waits for it.
TEST(Ownership, LatePeerIsNotInTheQueueOfAnEarlierClaim) {
  const WorldModel model = TwoBodies();
  Ownership nine(9, model);
  std::int64_t now_ns = 1'000'000'000;
  EventsSent(nine, now_ns, 1, EventKind::kGrant);
  MembershipChange seven{.kind = Kind::kJoined, .peer = 7, .claim_count = 1};
  seven.claims[0] = {kOwn, 2, true};
  nine.OnMembership(seven);
  EventsSent(nine, now_ns, 5500, EventKind::kGrant);
  ASSERT_EQ(nine.authority(0), 7U);
  nine.OnMembership({.kind = Kind::kJoined, .peer = 3});
  EventsSent(nine, now_ns, 100, EventKind::kGrant);
  nine.OnMembership({.kind = Kind::kLost, .peer = 7});
  EventsSent(nine, now_ns, 310, EventKind::kGrant);
  EXPECT_EQ(nine.authority(0), 9U);
}

}  // namespace
}  // namespace tandem
