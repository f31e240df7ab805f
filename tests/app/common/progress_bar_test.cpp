#include "app/common/progress_bar.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(ProgressLine, EstimatesRemainingTimeFromProgress) {
  // a quarter took 10 s: 30 s more
  EXPECT_EQ(ProgressLine(3, 40, 0.25, 10), "[#######                       ] 3 of 40, 30 s left");
  EXPECT_EQ(ProgressLine(20, 40, 0.5, 600),
            "[###############               ] 20 of 40, 10 min left");
  EXPECT_EQ(ProgressLine(20, 40, 0.5, 36000),
            "[###############               ] 20 of 40, 10.0 h left");
  EXPECT_EQ(ProgressLine(40, 40, 1, 600), "[##############################] 40 of 40, 0 s left");
}

TEST(ProgressLine, OmitsUnknownRemainingTime) {
  EXPECT_EQ(ProgressLine(0, 40, 0, 0), "[                              ] 0 of 40");
}

}  // namespace
}  // namespace tandem
