#include "app/connection/fetch_consent.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tandem {
namespace {

using ::testing::HasSubstr;

OfferedScene Offered(std::uint64_t bytes) {
  return {.name = "gear", .from = "anna", .files = 3, .bytes = bytes};
}

TEST(FetchConsent, IsRequestedAgainOnceTheSizeIsKnown) {
  FetchConsent consent;
  const std::string reported = consent.Refuses(Sha256{7}, Offered(98'000'000));
  EXPECT_THAT(reported, HasSubstr("scene gear, 3 files, 98 MB, from anna"));
  EXPECT_THAT(reported, HasSubstr("press the button again"));
  EXPECT_EQ(consent.Refuses(Sha256{7}, Offered(98'000'000)), "");
}

TEST(FetchConsent, DoesNotCoverALargerSize) {
  FetchConsent consent;
  EXPECT_NE(consent.Refuses(Sha256{7}, Offered(98'000'000)), "");
  EXPECT_THAT(consent.Refuses(Sha256{7}, Offered(900'000'000)), HasSubstr("900 MB"));
  EXPECT_EQ(consent.Refuses(Sha256{7}, Offered(900'000'000)), "");
}

TEST(FetchConsent, DoesNotCoverAnotherScene) {
  FetchConsent consent;
  EXPECT_NE(consent.Refuses(Sha256{7}, Offered(98'000'000)), "");
  EXPECT_NE(consent.Refuses(Sha256{8}, Offered(98'000'000)), "");
}

TEST(FetchConsent, FirstPressCoversSmallFiles) {
  FetchConsent consent;
  EXPECT_EQ(consent.Refuses(Sha256{7}, Offered(FetchConsent::kSmallBytes)), "");
  EXPECT_NE(consent.Refuses(Sha256{7}, Offered(FetchConsent::kSmallBytes + 1)), "");
}

}  // namespace
}  // namespace tandem
