#include "collab/dds/networks/announced_sources.h"

#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr std::int64_t kMsNs = 1'000'000;
constexpr double kLease_s = 2.6;
constexpr ProgramId kMember{1, 2, 3};
constexpr std::uint32_t kOwn = 10;        // where the member is
constexpr std::uint32_t kStrangers = 66;  // where a stranger sends the same announcement from

/// DDS as far as it matters here: it answers a program where the first announcement came from that
/// it saw, and forgets the program when it sees nothing of it for its lease.
class RememberedProgram {
 public:
  void Hear(AnnouncedSources& sources, std::uint32_t from, double lease_s, std::int64_t now_ns) {
    if (now_ns >= until_ns_) answered_.reset();
    if (!sources.Lets(kMember, from, lease_s, now_ns)) return;
    if (!answered_ && lease_s == 0) return;
    if (!answered_) answered_ = from;
    if (lease_s > 0) lease_ns_ = static_cast<std::int64_t>(1e9 * lease_s);
    until_ns_ = now_ns + lease_ns_;
  }
  std::optional<std::uint32_t> answered() const { return answered_; }

 private:
  std::optional<std::uint32_t> answered_;
  std::int64_t lease_ns_ = 0;
  std::int64_t until_ns_ = 0;
};

/// Sends the member's announcements each 650 ms and its data each 10 ms, and each stranger's copy
/// `copies` times as often as the former. Returns when DDS answers the member where it is, s; no
/// value: not in that time.
std::optional<double> AnsweredAfter(AnnouncedSources& sources, int strangers, int copies,
                                    double strangers_lease_s, double within_s) {
  RememberedProgram remembered;
  const auto steps = static_cast<int>(100 * within_s);
  for (int step = 0; step < steps; ++step) {
    const std::int64_t now_ns = 10 * kMsNs * (step + 1);
    for (int one = 0; one < strangers; ++one) {
      if (step * copies % 65 >= copies) continue;
      remembered.Hear(sources, kStrangers + static_cast<std::uint32_t>(one), strangers_lease_s,
                      now_ns);
    }
    if (step % 65 == 3) remembered.Hear(sources, kOwn, kLease_s, now_ns);
    remembered.Hear(sources, kOwn, 0, now_ns);
    if (remembered.answered() == kOwn) return 0.01 * step;
  }
  return std::nullopt;
}

TEST(AnnouncedSources, MemberIsAnsweredThoughAStrangerAnnouncedItFirst) {
  for (const int copies : {1, 13, 65}) {
    AnnouncedSources sources(1);
    const std::optional<double> after_s = AnsweredAfter(sources, 1, copies, kLease_s, 30);
    ASSERT_TRUE(after_s) << copies;
    EXPECT_GT(*after_s, 5) << "it had time to be met where it was announced first";
    EXPECT_LT(*after_s, 10) << copies;
  }
}

TEST(AnnouncedSources, DdsForgetsALongLeaseBeforeTheMemberIsTakenAnew) {
  AnnouncedSources sources(1);
  const std::optional<double> after_s = AnsweredAfter(sources, 1, 13, 20, 60);
  ASSERT_TRUE(after_s);
  EXPECT_GT(*after_s, 25);
  EXPECT_LT(*after_s, 30);
}

TEST(AnnouncedSources, MemberIsAnsweredAmongStrangersOfManyAddresses) {
  for (const int strangers : {3, 15}) {
    AnnouncedSources sources(1);
    EXPECT_TRUE(AnsweredAfter(sources, strangers, 5, kLease_s, 60.0 * strangers)) << strangers;
  }
}

TEST(AnnouncedSources, ProgramOfTwoNetworksIsHeardByBothOnceItIsMet) {
  AnnouncedSources sources(1);
  EXPECT_TRUE(sources.Lets(kMember, 10, kLease_s, 1 * kMsNs));
  EXPECT_FALSE(sources.Lets(kMember, 20, kLease_s, 2 * kMsNs)) << "DDS answers at one";
  EXPECT_TRUE(sources.Lets(kMember, 20, 0, 3 * kMsNs)) << "data come by both";
  sources.SetMet(std::vector<ProgramId>{kMember});
  for (std::int64_t ms = 4; ms < 100'000; ms += 650) {
    EXPECT_TRUE(sources.Lets(kMember, 10, kLease_s, ms * kMsNs));
    EXPECT_TRUE(sources.Lets(kMember, 20, kLease_s, ms * kMsNs));
    EXPECT_TRUE(sources.Lets(kMember, 20, 0, ms * kMsNs));
  }
}

TEST(AnnouncedSources, ProgramOfOneAddressIsAlwaysHeard) {
  AnnouncedSources sources(1);
  for (std::int64_t ms = 1; ms < 100'000; ms += 650) {
    EXPECT_TRUE(sources.Lets(kMember, 10, kLease_s, ms * kMsNs));
    EXPECT_TRUE(sources.Lets(kMember, 10, 0, ms * kMsNs));
  }
}

TEST(AnnouncedSources, StrangerAloneTakesNothingFromAMemberThatIsMetLater) {
  AnnouncedSources sources(1);
  sources.Lets(kMember, kStrangers, kLease_s, 1 * kMsNs);
  sources.Lets(kMember, kOwn, kLease_s, 2 * kMsNs);
  sources.SetMet(std::vector<ProgramId>{kMember});
  sources.SetMet({});  // lost again, and not announced meanwhile
  EXPECT_TRUE(sources.Lets(kMember, kOwn, kLease_s, 3 * kMsNs)) << "it begins anew";
}

TEST(AnnouncedSources, ForgedProgramsAreBounded) {
  AnnouncedSources sources(1);
  ProgramId forged{};
  for (std::uint32_t i = 0; i < 100'000; ++i) {
    forged = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8U),
              static_cast<std::uint8_t>(i >> 16U), 7};
    EXPECT_TRUE(sources.Lets(forged, kStrangers, kLease_s, (i + 1) * kMsNs));
  }
  EXPECT_TRUE(sources.Lets(kMember, kOwn, kLease_s, 100'001 * kMsNs));
}

}  // namespace
}  // namespace tandem
