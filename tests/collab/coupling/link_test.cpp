#include <cmath>

#include <gtest/gtest.h>

#include "collab/coupling/delay_meter.h"
#include "engine/base/units.h"

namespace tandem {
namespace {

TEST(DelayMeter, HoldsThePeakForTwoSeconds) {
  DelayMeter meter;
  std::int64_t now = 1000 * kMs;
  const auto run = [&](double seconds, std::int64_t age_ms) {
    for (int i = 0; i < static_cast<int>(1000 * seconds); ++i, now += kMs) {
      meter.Add(now, age_ms * kMs);
    }
  };
  run(0.5, 40);
  EXPECT_DOUBLE_EQ(meter.peak_loop_age_s(), 0.040);
  run(0.001, 300);
  run(1.8, 40);
  EXPECT_DOUBLE_EQ(meter.peak_loop_age_s(), 0.300);
  run(0.4, 40);
  EXPECT_DOUBLE_EQ(meter.peak_loop_age_s(), 0.040);
}

TEST(DelayMeter, ForgetsDelaysFromBeforeASilence) {
  DelayMeter meter;
  meter.Add(1000 * kMs, 700 * kMs);
  meter.Add(9000 * kMs, 50 * kMs);
  EXPECT_DOUBLE_EQ(meter.peak_loop_age_s(), 0.050);
}

}  // namespace
}  // namespace tandem
