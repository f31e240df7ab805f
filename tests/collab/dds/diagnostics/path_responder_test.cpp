#include "collab/dds/diagnostics/path_responder.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "collab/trace/path_record.h"
#include "engine/base/units.h"

namespace tandem {
namespace {

constexpr std::array<std::uint8_t, 32> kLineSecret{7};

using LineBytes = std::vector<std::byte>;

template <typename Message>
LineBytes LinePacket(const Message& message, std::size_t size) {
  LineBytes packet(size);
  std::memcpy(packet.data(), &message, std::min(size, sizeof message));
  return packet;
}

/// A responder, a requester at some address, and what goes between them; time is the test's.
class PathResponderTest : public ::testing::Test {
 protected:
  PathResponderTest() { ask_.terms = {.rate_hz = 1000, .samples = 5000, .bytes = 200}; }

  void Give(const LineBytes& packet, const PathResponder::Address& from) {
    received_ += packet.size();
    responder_.Take(
        packet, from, now_ns_,
        [this] {
          return may_answer_;
        },
        send_);
  }
  void Give(const LineBytes& packet) { Give(packet, requester_); }
  /// Returns the answer to `ask_` as that word; nothing: none came.
  std::optional<PathRequest> Ask(PathMessageKind word) {
    sent_.clear();
    ask_.head.word = word;
    Give(LinePacket(ask_, kPathRequestBytes));
    if (sent_.empty()) return std::nullopt;
    EXPECT_LE(sent_.back().second.size(), kPathRequestBytes);
    return MessageIn<PathRequest>(sent_.back().second);
  }
  bool Begin() {
    const std::optional<PathRequest> offer = Ask(PathMessageKind::kAsk);
    if (!offer || offer->head.word != PathMessageKind::kOffer) return false;
    ask_.token = offer->token;
    const std::optional<PathRequest> begun = Ask(PathMessageKind::kStart);
    sent_.clear();
    return begun && begun->head.word == PathMessageKind::kBegun;
  }
  void Sample(std::uint32_t seq, std::int64_t sent_ns) {
    PathSample sample;
    sample.head.word = PathMessageKind::kSample;
    sample.head.nonce = ask_.head.nonce;
    sample.seq = seq;
    sample.sent_ns = sent_ns;
    Give(LinePacket(sample, ask_.terms.bytes));
  }
  /// Goes on a millisecond at a time, and returns how many samples went out.
  int Run(int ms, bool requester_sends) {
    int count = 0;
    for (int i = 0; i < ms; ++i) {
      now_ns_ += kMs;
      if (requester_sends) Sample(next_++, now_ns_);
      sent_.clear();
      responder_.SendDue(now_ns_, send_);
      count += static_cast<int>(sent_.size());
    }
    return count;
  }

  PathResponder responder_{kLineSecret};
  PathResponder::Address requester_{0x0100007f, 999};
  PathRequest ask_;
  std::int64_t now_ns_ = 100 * kSecondNs;
  std::uint32_t next_ = 0;
  bool may_answer_ = true;
  std::size_t received_ = 0;  // bytes
  std::vector<std::pair<PathResponder::Address, LineBytes>> sent_;
  PathResponder::Send send_ = [this](const PathResponder::Address& to,
                                     std::span<const std::byte> packet) {
    sent_.emplace_back(to, LineBytes(packet.begin(), packet.end()));
  };
};

TEST_F(PathResponderTest, SendsOnlyAfterItsTokenReturns) {
  ASSERT_TRUE(Ask(PathMessageKind::kAsk));
  EXPECT_EQ(responder_.streams(), 0U);
  EXPECT_EQ(Run(1000, true), 0);
  // an ask that is made up, of another address, for other terms
  EXPECT_FALSE(Ask(PathMessageKind::kStart));
  ask_.token = Ask(PathMessageKind::kAsk)->token;
  const PathResponder::Address honest = std::exchange(requester_, {0x02000a0a, 999});
  EXPECT_FALSE(Ask(PathMessageKind::kStart));
  requester_ = honest;
  ask_.terms.samples = 5001;
  EXPECT_FALSE(Ask(PathMessageKind::kStart));
  ask_.terms.samples = 5000;
  EXPECT_EQ(responder_.streams(), 0U);
  const std::optional<PathRequest> begun = Ask(PathMessageKind::kStart);
  ASSERT_TRUE(begun);
  EXPECT_EQ(begun->head.word, PathMessageKind::kBegun);
  EXPECT_EQ(responder_.streams(), 1U);
  next_ = 0;
  EXPECT_GT(Run(1000, true), 900);
}

TEST_F(PathResponderTest, NeverSendsMoreThanItReceived) {
  ask_.head.word = PathMessageKind::kAsk;
  Give(LinePacket(ask_, sizeof ask_));  // shorter than it must be
  EXPECT_TRUE(sent_.empty());
  may_answer_ = false;
  Give(LinePacket(ask_, kPathRequestBytes));
  EXPECT_TRUE(sent_.empty());
  may_answer_ = true;
  ASSERT_TRUE(Begin());
  PathArrivals fetch;
  fetch.head.word = PathMessageKind::kFetch;
  fetch.head.nonce = ask_.head.nonce;
  Give(LinePacket(fetch, sizeof fetch - 8));
  EXPECT_TRUE(sent_.empty());
  Give(LinePacket(fetch, kPathFetchBytes), {0x09090909, 999});  // no stream has that address
  EXPECT_TRUE(sent_.empty());
  Give(LinePacket(fetch, kPathFetchBytes));
  ASSERT_EQ(sent_.size(), 1U);
  EXPECT_EQ(sent_[0].second.size(), kPathFetchBytes);
}

TEST_F(PathResponderTest, EndsWhenTheAskerFallsSilent) {
  ASSERT_TRUE(Begin());
  EXPECT_GT(Run(1000, true), 900);
  EXPECT_LE(Run(3000, false), 3000);
  EXPECT_EQ(Run(1000, false), 0);
  EXPECT_FALSE(responder_.NextDueNs());
  EXPECT_EQ(Run(500, true), 0);
}

// One sample a second keeps a stream from being silent. Four go out for each that comes, and three
// seconds' worth.
TEST_F(PathResponderTest, SendsAtMostFourSamplesPerReceivedSampleAndThreeSecondsAhead) {
  ask_.terms.samples = 600'000;
  ASSERT_TRUE(Begin());
  int count = 0;
  for (int second = 0; second < 30; ++second) {
    Sample(next_++, now_ns_);
    count += Run(1000, false);
  }
  EXPECT_GT(count, 2900);
  EXPECT_LE(count, 3000 + 4 * 30);
}

TEST_F(PathResponderTest, RefusesExcessiveRatesAndTooManyRequesters) {
  const auto word = [this] {
    const std::optional<PathRequest> answer = Ask(PathMessageKind::kAsk);
    return answer ? answer->head.word : PathMessageKind::kDone;
  };
  const PathTerms good = ask_.terms;
  for (const PathTerms& terms :
       {PathTerms{1001, 10, 200}, PathTerms{0, 10, 200}, PathTerms{1000, 600'001, 200},
        PathTerms{1000, 0, 200}, PathTerms{1000, 10, 1401}, PathTerms{1000, 10, 10}}) {
    ask_.terms = terms;
    EXPECT_EQ(word(), PathMessageKind::kRefuse);
  }
  ask_.terms = good;
  ask_.head.version = 9;
  EXPECT_EQ(word(), PathMessageKind::kRefuse);
  ask_.head.version = kPathVersion;
  ASSERT_TRUE(Begin());
  EXPECT_EQ(word(), PathMessageKind::kOffer) << "the same, whose answer was lost";
  ask_.head.nonce = 2;
  EXPECT_EQ(word(), PathMessageKind::kRefuse) << "another of that address";
  requester_ = {0x0200007f, 1};
  ASSERT_TRUE(Begin());
  requester_ = {0x0300007f, 1};
  EXPECT_EQ(word(), PathMessageKind::kRefuse) << "a third";
  EXPECT_EQ(responder_.streams(), PathResponder::kMostStreams);
  // a stream that has gone makes room
  now_ns_ += PathResponder::kKeptNs + kSecondNs;
  responder_.SendDue(now_ns_, send_);
  EXPECT_EQ(responder_.streams(), 0U);
  EXPECT_EQ(word(), PathMessageKind::kOffer);
}

TEST_F(PathResponderTest, ReportsArrivalTimesAndLosses) {
  ask_.terms.samples = 300;
  ASSERT_TRUE(Begin());
  for (std::uint32_t i = 0; i < 300; ++i) {
    now_ns_ += kMs;
    if (i % 10 == 4) continue;
    Sample(i, now_ns_ - (40 + i) * kMs);
    if (i % 10 == 5) Sample(i, now_ns_);  // twice: the first counts
  }
  std::map<std::uint32_t, std::int64_t> reported;
  for (const std::uint32_t first : {0U, 128U, 256U}) {
    sent_.clear();
    PathArrivals fetch;
    fetch.head.word = PathMessageKind::kFetch;
    fetch.head.nonce = ask_.head.nonce;
    fetch.first = first;
    Give(LinePacket(fetch, kPathFetchBytes));
    ASSERT_EQ(sent_.size(), 1U);
    const auto answer = MessageIn<PathArrivals>(sent_[0].second);
    for (std::uint32_t i = 0; i < answer->count; ++i) reported[first + i] = answer->ns[i];
  }
  ASSERT_EQ(reported.size(), 300U);
  for (const auto& [seq, ns] : reported) {
    EXPECT_EQ(ns, seq % 10 == 4 ? PathRecord::kNever : (40 + seq) * kMs) << seq;
  }
}

TEST_F(PathResponderTest, EchoesTheNewestTimestampAndItsHoldTime) {
  ASSERT_TRUE(Begin());
  now_ns_ += 50 * kMs;
  responder_.SendDue(now_ns_, send_);
  Sample(1, 777);
  Sample(0, 555);  // older
  now_ns_ += 3 * kMs;
  sent_.clear();
  responder_.SendDue(now_ns_, send_);
  ASSERT_FALSE(sent_.empty());
  const auto sample = MessageIn<PathSample>(sent_.back().second);
  EXPECT_EQ(sample->echo_ns, 777);
  EXPECT_EQ(sample->held_ns, 3 * kMs);
  EXPECT_EQ(sample->received, 2U);
}

TEST_F(PathResponderTest, IgnoresOtherPackets) {
  const auto is_line = [this](const LineBytes& packet) {
    return responder_.Take(
        packet, requester_, now_ns_,
        [] {
          return true;
        },
        send_);
  };
  EXPECT_FALSE(is_line({}));
  EXPECT_FALSE(is_line(LineBytes(64)));
  PathHeader head;
  head.word = static_cast<PathMessageKind>(99);
  EXPECT_TRUE(is_line(LinePacket(head, sizeof head)));
  EXPECT_TRUE(sent_.empty());
}

}  // namespace
}  // namespace tandem
