#include "app/peer/text/notification_limiter.h"

#include <gmock/gmock.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::int64_t kTickNs = 20 * kMs;

TEST(NotificationLimiter, QuietSessionsNewsAreImmediate) {
  NotificationLimiter news;
  news.Add("anna", "anna joined");
  news.Add("", "your hand begins");
  EXPECT_THAT(news.Due(kTickNs), ElementsAre("anna joined", "your hand begins"));
  EXPECT_THAT(news.Due(2 * kTickNs), IsEmpty());
}

TEST(NotificationLimiter, EachProgramIsReportedOnceASecondWithItsNewestState) {
  NotificationLimiter news;
  std::vector<std::string> output;
  // a peer comes and goes fifty times a second for ten seconds
  for (std::int64_t i = 0; i < 500; ++i) {
    news.Add("vic", "vic joined " + std::to_string(i));
    for (const std::string& line : news.Due(i * kTickNs)) output.push_back(line);
  }
  EXPECT_EQ(output.size(), 10U);
  EXPECT_EQ(output.front(), "vic joined 0");
  const std::vector<std::string> rest = news.Rest();
  EXPECT_THAT(rest, ElementsAre("vic joined 497", "vic joined 498", "vic joined 499",
                                "(487 more lines left out)"));
}

TEST(NotificationLimiter, TotalLineRateIsBounded) {
  NotificationLimiter news;
  std::vector<std::int64_t> said_ns;
  for (std::int64_t i = 0; i < 500; ++i) {
    for (int n = 0; n < 50; ++n) {
      const std::string name = "vic-" + std::to_string(50 * i + n);
      news.Add(name, name + " joined");
    }
    for (const std::string& line : news.Due(i * kTickNs)) {
      static_cast<void>(line);
      said_ns.push_back(i * kTickNs);
    }
  }
  ASSERT_GT(said_ns.size(), NotificationLimiter::kMostPerSecond);
  for (std::size_t i = NotificationLimiter::kMostPerSecond; i < said_ns.size(); ++i) {
    EXPECT_GE(said_ns[i] - said_ns[i - NotificationLimiter::kMostPerSecond], 1000 * kMs);
  }
  EXPECT_GT(news.left_out(), 24'000U);
}

TEST(NotificationLimiter, FloodHidesNoLocalMessage) {
  NotificationLimiter news;
  news.Add("", "your hand let go of ball");
  for (int n = 0; n < 1000; ++n) news.Add("vic-" + std::to_string(n), "joined");
  const std::vector<std::string> output = news.Due(kTickNs);
  ASSERT_FALSE(output.empty());
  EXPECT_EQ(output.front(), "your hand let go of ball");
}

TEST(NotificationLimiter, LinesBelongToTheLongestMatchingName) {
  EXPECT_EQ(SubjectOf("anna b joined", {"anna", "anna b", "b"}), "anna b");
  EXPECT_EQ(SubjectOf("annab joined", {"anna"}), "");
  EXPECT_EQ(SubjectOf("you are the authority of ball", {"anna"}), "");
}

}  // namespace
}  // namespace tandem
