#include "collab/receive/sample_validator.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

constexpr PeerId kSelf = 1;
constexpr PeerId kStranger = 2;
constexpr ObjectId kPeg = 5;
constexpr std::uint32_t kEpoch = 7;

class SampleValidatorTest : public ::testing::Test {
 protected:
  SampleValidatorTest() { Tell(MembershipChange::Kind::kJoined, kEpoch); }

  void Tell(MembershipChange::Kind kind, std::uint32_t epoch) {
    MembershipChange change;
    change.kind = kind;
    change.peer = kStranger;
    change.claim_count = 1;
    change.claims[0] = {.object = kPeg, .epoch = epoch, .held = true};
    gate.OnMembership(change);
  }
  static ObjectState State(std::uint32_t seq) {
    ObjectState state;
    state.peer = kStranger;
    state.object = kPeg;
    state.epoch = kEpoch;
    state.seq = seq;
    return state;
  }
  static CouplingLinks Links(std::uint32_t seq, std::int64_t echo_ns) {
    CouplingLinks links;
    links.from = kStranger;
    links.object = kPeg;
    links.seq = seq;
    links.count = 1;
    links.entries[0].to = kSelf;
    links.entries[0].echo_ns = echo_ns;
    return links;
  }
  std::uint64_t Dropped(Drop reason) const {
    return drops.CountsOf(kStranger)[static_cast<std::size_t>(reason)];
  }

  DropTable drops;
  SampleValidator gate{kSelf, {4, kPeg}, drops};
};

TEST_F(SampleValidatorTest, AcceptsValidSamples) {
  gate.NoteSent(1000);
  for (std::uint32_t seq = 0xFFFFFFF0U; seq != 16; ++seq) {
    EXPECT_TRUE(gate.Accept(State(seq)));
    EXPECT_TRUE(gate.Accept(Links(seq, 1000)));
  }
  EXPECT_TRUE(gate.Accept(Links(16, 0)));  // has not heard us yet
  EXPECT_EQ(SumOf(drops.Total()), 0U);
}

TEST_F(SampleValidatorTest, ReplayedStateIsDroppedAndCounted) {
  EXPECT_TRUE(gate.Accept(State(10)));
  EXPECT_FALSE(gate.Accept(State(10)));
  EXPECT_FALSE(gate.Accept(State(3)));
  EXPECT_TRUE(gate.Accept(State(11)));
  EXPECT_EQ(Dropped(Drop::kReplayed), 2U);
  EXPECT_EQ(SumOf(drops.Total()), 2U);
}

TEST_F(SampleValidatorTest, WrongEpochIsDroppedWithoutBlockingTheHolder) {
  ObjectState forged = State(10);
  forged.epoch = kEpoch + 1'000'000;
  EXPECT_FALSE(gate.Accept(forged));
  forged.epoch = kEpoch - 1;
  EXPECT_FALSE(gate.Accept(forged));
  EXPECT_TRUE(gate.Accept(State(1)));
  EXPECT_EQ(Dropped(Drop::kWrongEpoch), 2U);
}

TEST_F(SampleValidatorTest, NewClaimRestartsSequenceNumbers) {
  EXPECT_TRUE(gate.Accept(State(1000)));
  Tell(MembershipChange::Kind::kClaims, kEpoch + 1);
  EXPECT_FALSE(gate.Accept(State(1001)));
  ObjectState state = State(1);
  state.epoch = kEpoch + 1;
  EXPECT_TRUE(gate.Accept(state));
}

TEST_F(SampleValidatorTest, StateOfAnUnclaimedBodyIsDropped) {
  ObjectState state = State(1);
  state.object = 4;
  EXPECT_FALSE(gate.Accept(state));
  state.object = 99;  // no body that moves
  EXPECT_FALSE(gate.Accept(state));
  EXPECT_EQ(Dropped(Drop::kWrongOwner), 2U);
}

TEST_F(SampleValidatorTest, EchoOfAnUnsentTimestampIsDropped) {
  for (std::int64_t frame = 1; frame <= 20'000; ++frame) gate.NoteSent(1'000'000 * frame + 17);
  constexpr std::int64_t kNewest = 1'000'000 * std::int64_t{20'000} + 17;
  EXPECT_FALSE(gate.Accept(Links(1, kNewest + 1'000'000)));  // in the future
  EXPECT_FALSE(gate.Accept(Links(2, kNewest - 1)));          // between two frames
  EXPECT_FALSE(gate.Accept(Links(3, -5)));
  EXPECT_FALSE(gate.Accept(Links(4, 1'000'017)));  // so old that no link is that long
  EXPECT_TRUE(gate.Accept(Links(5, kNewest)));
  EXPECT_TRUE(gate.Accept(Links(6, kNewest - 8'000'000'000)));
  EXPECT_EQ(Dropped(Drop::kBadEcho), 4U);
}

TEST(StampRing, ContainsOnlyStoredTimestamps) {
  StampRing<64> ring;
  std::vector<std::int64_t> sent;
  EXPECT_FALSE(ring.Has(0));
  for (std::int64_t i = 0; i < 200; ++i) {
    sent.push_back(10 * i + i * i % 7);
    ring.Add(sent.back());
    const std::size_t kept = std::min<std::size_t>(sent.size(), 64);
    const std::vector<std::int64_t> last(sent.end() - static_cast<std::ptrdiff_t>(kept),
                                         sent.end());
    for (std::int64_t stamp = -1; stamp <= sent.back() + 1; ++stamp) {
      EXPECT_EQ(ring.Has(stamp), std::find(last.begin(), last.end(), stamp) != last.end())
          << i << " " << stamp;
    }
  }
}

TEST_F(SampleValidatorTest, ReturningPeerContinuesItsSequence) {
  EXPECT_TRUE(gate.Accept(State(1000)));
  Tell(MembershipChange::Kind::kLost, kEpoch);
  EXPECT_TRUE(gate.Accept(State(500)));  // a sender who is not here: it passes, unused
  Tell(MembershipChange::Kind::kBack, kEpoch);
  EXPECT_TRUE(gate.Accept(State(501)));
  EXPECT_EQ(SumOf(drops.Total()), 0U);
}

// A holder claims anew what it keeps, and its claim takes longer than its states (hostile seed
// 773).
TEST_F(SampleValidatorTest, SharedHolderMayAdvanceItsEpochBeforeItsClaim) {
  SampleValidator both(kSelf, {4, kPeg}, drops, {false, true});
  const auto tell = [&](MembershipChange::Kind kind, std::uint32_t epoch, bool held) {
    MembershipChange change{.kind = kind, .peer = kStranger, .claim_count = 1};
    change.claims[0] = {.object = kPeg, .epoch = epoch, .held = held};
    both.OnMembership(change);
  };
  const auto admits = [&](std::uint32_t seq, std::uint32_t epoch) {
    ObjectState state = State(seq);
    state.epoch = epoch;
    return both.Accept(state);
  };
  using Kind = MembershipChange::Kind;
  tell(Kind::kJoined, kEpoch, true);
  EXPECT_FALSE(admits(1, kEpoch + 2)) << "there is nothing yet that it could count on from";
  EXPECT_TRUE(admits(1, kEpoch));
  EXPECT_FALSE(admits(1'000'000, kEpoch + 2)) << "it does not follow";
  EXPECT_TRUE(admits(2, kEpoch + 2));
  EXPECT_FALSE(admits(2, kEpoch + 2));
  EXPECT_FALSE(admits(3, kEpoch - 1));
  EXPECT_FALSE(admits(3, kEpoch + 1)) << "epochs do not go back";
  tell(Kind::kClaims, kEpoch + 2, true);
  EXPECT_FALSE(admits(2, kEpoch + 2)) << "it was taken before the claim came";
  EXPECT_TRUE(admits(3, kEpoch + 2));
  tell(Kind::kClaims, kEpoch + 3, false);
  EXPECT_TRUE(admits(4, kEpoch + 3));
  EXPECT_FALSE(admits(5, kEpoch + 4)) << "it is in nobody's hand";
}

TEST_F(SampleValidatorTest, AllocatesNothing) {
  const testing::AllocationCounter allocations;
  Tell(MembershipChange::Kind::kClaims, kEpoch + 1);
  gate.NoteSent(1);
  gate.Accept(State(1));
  gate.Accept(Links(1, 2));
  EXPECT_EQ(allocations.count(), 0);
}

TEST(DropTable, CountsBySenderAndReasonAndPoolsTheOverflow) {
  DropTable drops;
  for (PeerId peer = 1; peer <= 1000; ++peer) drops.Count(peer, Drop::kHuge);
  drops.Count(3, Drop::kNotFinite);
  drops.Count(0, Drop::kNoOwner);
  EXPECT_EQ(drops.CountsOf(3)[static_cast<std::size_t>(Drop::kHuge)], 1U);
  EXPECT_EQ(drops.CountsOf(3)[static_cast<std::size_t>(Drop::kNotFinite)], 1U);
  EXPECT_EQ(drops.Total()[static_cast<std::size_t>(Drop::kHuge)], 1000U);
  EXPECT_EQ(SumOf(drops.Total()), 1002U);
  std::uint64_t sum = 0;
  for (const auto& [peer, counts] : drops.Rows()) sum += SumOf(counts);
  EXPECT_EQ(sum, 1002U);
}

}  // namespace
}  // namespace tandem
