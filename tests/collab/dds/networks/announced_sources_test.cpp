#include "collab/dds/networks/announced_sources.h"

#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr std::int64_t kMsNs = 1'000'000;
constexpr double kLease_s = 2;
constexpr ProgramId kMember{1, 2, 3};
constexpr std::uint64_t kOwn = 10;        // where the member is
constexpr std::uint64_t kStrangers = 66;  // where a stranger sends the same announcement from

/// DDS as far as it matters here: it answers a program where the first announcement came from that
/// it saw, and forgets the program when it sees nothing of it for its lease.
class RememberedProgram {
 public:
  explicit RememberedProgram(AnnouncedSources& sources) : sources_(sources) {}

  void HearAnnouncement(std::uint64_t way, double lease_s, std::int64_t now_ns) {
    if (sources_.LetsAnnounce(kMember, {.way = way, .lease_s = lease_s}, now_ns, new_turn_)) {
      Renew(now_ns);
      if (!answered_) lease_ns_ = static_cast<std::int64_t>(1e9 * lease_s);
      if (!answered_) answered_ = way;
      until_ns_ = now_ns + lease_ns_;
    }
  }
  void HearData(std::int64_t now_ns) {
    if (sources_.Lets(kMember, now_ns)) Renew(now_ns);
  }
  std::optional<std::uint64_t> answered() const { return answered_; }

 private:
  void Renew(std::int64_t now_ns) {
    if (now_ns >= until_ns_) answered_.reset();
    if (answered_) until_ns_ = now_ns + lease_ns_;
  }

  AnnouncedSources& sources_;
  std::optional<std::uint64_t> answered_;
  std::int64_t lease_ns_ = 0;
  std::int64_t until_ns_ = 0;
  bool new_turn_ = false;
};

struct Attack {
  int strangers = 1;
  int copies = 13;  // sent of an announcement while the member sends one
  double lease_s = kLease_s;
  double ends_s = 1e9;
};

/// Sends the member's announcements each 650 ms and its data each 10 ms, and each stranger's copies
/// before them. Returns when DDS answers the member where it is, s; no value: not in that time.
std::optional<double> AnsweredAfter(AnnouncedSources& sources, const Attack& attack,
                                    double within_s) {
  RememberedProgram remembered(sources);
  const auto steps = static_cast<int>(100 * within_s);
  for (int step = 0; step < steps; ++step) {
    const std::int64_t now_ns = 10 * kMsNs * (step + 1);
    for (int one = 0; one < attack.strangers && 0.01 * step < attack.ends_s; ++one) {
      if (step * attack.copies % 65 >= attack.copies) continue;
      remembered.HearAnnouncement(kStrangers + static_cast<std::uint64_t>(one), attack.lease_s,
                                  now_ns);
    }
    if (step % 65 == 3) remembered.HearAnnouncement(kOwn, kLease_s, now_ns);
    remembered.HearData(now_ns);
    if (remembered.answered() == kOwn) return 0.01 * step;
  }
  return std::nullopt;
}

TEST(AnnouncedSources, MemberIsAnsweredThoughAStrangerAnnouncedItFirst) {
  for (const int copies : {1, 13, 65}) {
    AnnouncedSources sources(1);
    const std::optional<double> after_s = AnsweredAfter(sources, {.copies = copies}, 30);
    ASSERT_TRUE(after_s) << copies;
    EXPECT_GT(*after_s, 5) << "it had time to be met where it was announced first";
    EXPECT_LT(*after_s, 10.5) << copies;
  }
}

TEST(AnnouncedSources, MemberIsAnsweredSoonAfterAStrangerEnds) {
  AnnouncedSources sources(1);
  const std::optional<double> after_s = AnsweredAfter(sources, {.ends_s = 0.1}, 30);
  ASSERT_TRUE(after_s);
  EXPECT_GT(*after_s, 3);
  EXPECT_LT(*after_s, 8.5);
}

TEST(AnnouncedSources, LeaseThatDdsWouldKeepBeyondTheSilenceIsRefused) {
  for (const double lease_s : {0.0, 0.5, 20.0, 60.0}) {
    AnnouncedSources sources(1);
    const std::optional<double> after_s = AnsweredAfter(sources, {.lease_s = lease_s}, 30);
    ASSERT_TRUE(after_s) << lease_s;
    EXPECT_LT(*after_s, 1) << lease_s;
  }
}

TEST(AnnouncedSources, EachOfManyStrangersHasOneTurnBeforeTheMember) {
  for (const int strangers : {3, 15}) {
    AnnouncedSources sources(1);
    const std::optional<double> after_s =
        AnsweredAfter(sources, {.strangers = strangers, .copies = 5}, 300);
    ASSERT_TRUE(after_s) << strangers;
    EXPECT_LT(*after_s, 9.7 * strangers + 1) << strangers;
  }
}

TEST(AnnouncedSources, ProgramOfTwoNetworksIsHeardByBothOnceItIsMet) {
  AnnouncedSources sources(1);
  bool new_turn = false;
  const AnnouncedSource first{.way = 10, .lease_s = kLease_s};
  const AnnouncedSource second{.way = 20, .lease_s = kLease_s};
  EXPECT_TRUE(sources.LetsAnnounce(kMember, first, 1 * kMsNs, new_turn));
  EXPECT_FALSE(sources.LetsAnnounce(kMember, second, 2 * kMsNs, new_turn)) << "DDS answers at one";
  EXPECT_TRUE(sources.Lets(kMember, 3 * kMsNs)) << "data come by both";
  std::vector<ProgramId> met{kMember};
  sources.SetMet(met);
  for (std::int64_t ms = 4; ms < 100'000; ms += 650) {
    EXPECT_TRUE(sources.LetsAnnounce(kMember, first, ms * kMsNs, new_turn));
    EXPECT_TRUE(sources.LetsAnnounce(kMember, second, ms * kMsNs, new_turn));
    EXPECT_TRUE(sources.Lets(kMember, ms * kMsNs));
  }
  EXPECT_FALSE(new_turn);
}

TEST(AnnouncedSources, ProgramOfOneSourceIsAlwaysHeard) {
  AnnouncedSources sources(1);
  bool new_turn = false;
  const AnnouncedSource only{.way = 10, .lease_s = kLease_s};
  for (std::int64_t ms = 1; ms < 100'000; ms += 650) {
    EXPECT_TRUE(sources.LetsAnnounce(kMember, only, ms * kMsNs, new_turn));
    EXPECT_TRUE(sources.Lets(kMember, ms * kMsNs));
  }
  EXPECT_FALSE(new_turn);
}

TEST(AnnouncedSources, SourceThatFellSilentGivesWayToAnother) {
  AnnouncedSources sources(1);
  bool new_turn = false;
  sources.LetsAnnounce(kMember, {.way = 10, .lease_s = kLease_s}, 1 * kMsNs, new_turn);
  // it is at another address from now on
  std::int64_t taken_ms = 0;
  for (std::int64_t ms = 650; ms < 20'000 && taken_ms == 0; ms += 650) {
    const AnnouncedSource now{.way = 20, .lease_s = kLease_s};
    if (sources.LetsAnnounce(kMember, now, ms * kMsNs, new_turn)) taken_ms = ms;
  }
  EXPECT_GT(taken_ms, 3'000 + 4'000);
  EXPECT_LT(taken_ms, 3'000 + 4'000 + 3 * 650);
}

// A domain that has met nobody is silent itself meanwhile, and hears nothing.
TEST(AnnouncedSources, TurnLastsThoughNothingWasHeardInTheSilence) {
  AnnouncedSources sources(1);
  bool new_turn = false;
  const AnnouncedSource own{.way = kOwn, .lease_s = kLease_s};
  const AnnouncedSource copy{.way = kStrangers, .lease_s = kLease_s};
  std::int64_t ms = 1;
  for (; !new_turn; ms += 10) {
    ASSERT_LT(ms, 6000);
    sources.LetsAnnounce(kMember, copy, ms * kMsNs, new_turn);
    if (ms % 650 == 1 && !new_turn) sources.LetsAnnounce(kMember, own, ms * kMsNs, new_turn);
  }
  new_turn = false;
  ms += AnnouncedSources::kSilenceNs / kMsNs;
  EXPECT_FALSE(sources.LetsAnnounce(kMember, copy, ms * kMsNs, new_turn));
  EXPECT_FALSE(new_turn);
  EXPECT_TRUE(sources.LetsAnnounce(kMember, own, (ms + 600) * kMsNs, new_turn));
}

TEST(AnnouncedSources, LostMemberBeginsAnew) {
  AnnouncedSources sources(1);
  bool new_turn = false;
  sources.LetsAnnounce(kMember, {.way = kStrangers, .lease_s = kLease_s}, 1 * kMsNs, new_turn);
  std::vector<ProgramId> met{kMember};
  sources.SetMet(met);
  std::vector<ProgramId> none;
  sources.SetMet(none);
  EXPECT_TRUE(
      sources.LetsAnnounce(kMember, {.way = kOwn, .lease_s = kLease_s}, 3 * kMsNs, new_turn));
}

TEST(AnnouncedSources, InventedProgramsDisplaceFewOthers) {
  AnnouncedSources sources(1);
  bool new_turn = false;
  constexpr int kMembers = 30;
  const auto id = [](int number, std::uint8_t kind) {
    return ProgramId{static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8),
                     kind};
  };
  // each member is announced by a stranger first
  for (int one = 0; one < kMembers; ++one) {
    sources.LetsAnnounce(id(one, 1), {.way = kStrangers, .lease_s = kLease_s}, kMsNs, new_turn);
  }
  for (int one = 0; one < 200; ++one) {
    sources.LetsAnnounce(id(one, 2), {.way = kStrangers, .lease_s = kLease_s}, 2 * kMsNs, new_turn);
  }
  int displaced = 0;
  for (int one = 0; one < kMembers; ++one) {
    displaced +=
        sources.LetsAnnounce(id(one, 1), {.way = kOwn, .lease_s = kLease_s}, 3 * kMsNs, new_turn)
            ? 1
            : 0;
  }
  EXPECT_LE(displaced, 3);
}

}  // namespace
}  // namespace tandem
