#include "collab/receive/peer_inbox.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

TEST(DueQueue, OrdersByDueTimeThenByArrival) {
  DueQueue<int> queue(100);
  std::mt19937 random(1);
  std::vector<std::pair<std::int64_t, int>> expected;
  for (int i = 0; i < 100; ++i) {
    const std::int64_t due = random() % 20;
    ASSERT_TRUE(queue.Push(due, i));
    expected.emplace_back(due, i);
  }
  EXPECT_FALSE(queue.Push(0, 100));
  std::sort(expected.begin(), expected.end());
  for (const auto& [due, value] : expected) {
    EXPECT_EQ(queue.Due(due - 1), nullptr);
    ASSERT_NE(queue.Due(due), nullptr);
    EXPECT_EQ(*queue.Due(due), value);
    queue.Drop();
  }
  EXPECT_EQ(queue.Due(INT64_MAX), nullptr);
  EXPECT_TRUE(queue.Push(0, 1));
}

TEST(DueQueue, AllocatesNothingAfterwards) {
  DueQueue<int> queue(64);
  const testing::AllocationCounter counter;
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 64; ++i) queue.Push(-i, i);
    while (queue.Due(0) != nullptr) queue.Drop();
  }
  EXPECT_EQ(counter.count(), 0);
}

TEST(PeerInbox, StampsSamplesWithTheTimeTheyAreDue) {
  PeerDirectory directory(7, 42);
  PeerInbox inbox({.delay_ms = 100}, directory);
  ObjectState state;
  state.peer = 1;
  state.seq = 9;
  inbox.OnState(state, 5 * kMs);
  inbox.Collect();
  EXPECT_EQ(inbox.states().Due(105 * kMs - 1), nullptr);
  ASSERT_NE(inbox.states().Due(105 * kMs), nullptr);
  EXPECT_EQ(inbox.states().Due(105 * kMs)->seq, 9U);
}

// One sender's jitter and delay are its own: another's samples pass those that wait.
TEST(PeerInbox, SlowSenderDelaysNoOtherPeer) {
  PeerDirectory directory(7, 42);
  PeerInbox inbox({.delay_ms = 2}, directory);
  ASSERT_TRUE(inbox.Switch(1, {.delay_ms = 500, .jitter_ms = 400}));
  for (std::uint32_t seq = 1; seq <= 50; ++seq) {
    for (const PeerId peer : {PeerId{1}, PeerId{2}}) {
      ObjectState state;
      state.peer = peer;
      state.seq = seq;
      inbox.OnState(state, seq * kMs);
    }
  }
  inbox.Collect();
  std::uint32_t last = 0;
  while (const ObjectState* state = inbox.states().Due(52 * kMs)) {
    EXPECT_EQ(state->peer, 2U);
    EXPECT_EQ(state->seq, last + 1);
    last = state->seq;
    inbox.states().Drop();
  }
  EXPECT_EQ(last, 50U);
  EXPECT_EQ(inbox.states().size(), 50U);
}

TEST(PeerInbox, OneWayCutCanBeSwitchedAtRunTime) {
  PeerDirectory directory(7, 42);
  PeerInbox inbox({}, directory);
  ObjectState state;
  state.peer = 1;
  inbox.OnState(state, 1 * kMs);
  inbox.Switch(1, {.cut = true});
  for (std::int64_t t = 2; t < 10; ++t) inbox.OnState(state, t * kMs);
  inbox.Switch(0, {});
  inbox.OnState(state, 10 * kMs);
  inbox.Collect();
  EXPECT_EQ(inbox.states().size(), 2U);
}

TEST(PeerInbox, FloodOfOneSenderDoesNotDisplaceOthers) {
  PeerDirectory directory(7, 42);
  PeerInbox inbox({}, directory);
  ObjectState flood;
  flood.peer = 1;
  ObjectState other;
  other.peer = 2;
  std::uint64_t received = 0;
  for (std::int64_t frame = 1; frame <= 20; ++frame) {
    for (int i = 0; i < 10'000; ++i) inbox.OnState(flood, frame * kMs);
    inbox.OnState(other, frame * kMs);
    inbox.Collect();
    for (; inbox.states().Due(frame * kMs) != nullptr; inbox.states().Drop()) {
      if (inbox.states().Due(frame * kMs)->peer == 2) ++received;
    }
  }
  EXPECT_EQ(received, 20U);
  const auto full = static_cast<std::size_t>(Drop::kRingFull);
  EXPECT_GT(inbox.drops().CountsOf(1)[full], 100'000U);
  EXPECT_EQ(inbox.drops().CountsOf(2)[full], 0U);
}

TEST(PeerInbox, CountsOverflow) {
  PeerDirectory directory(7, 42);
  PeerInbox inbox({.delay_ms = 1000}, directory, 100);
  ObjectState state;
  state.peer = 1;
  for (int i = 0; i < 150; ++i) inbox.OnState(state, i);
  inbox.Collect();
  EXPECT_EQ(inbox.overflows(), 50U);
}

}  // namespace
}  // namespace tandem
