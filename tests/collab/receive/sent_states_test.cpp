#include "collab/receive/sent_states.h"

#include <gtest/gtest.h>

#include "engine/base/units.h"

namespace tandem {
namespace {

TEST(SentStates, OneStatePerPeriodIsComplete) {
  SentStates states;
  for (int i = 0; i < 1000; ++i) states.Add(1'000'000 * kMs + i * kMs, kMs);
  EXPECT_EQ(states.sent(), 1000U);
  EXPECT_EQ(states.wanted(), 1000U);
}

TEST(SentStates, LateSendsAreCountedAsMissing) {
  SentStates states;
  for (int i = 0; i < 500; ++i) states.Add(1'000'000 * kMs + 3 * i * kMs, 2 * kMs);
  EXPECT_EQ(states.sent(), 500U);
  EXPECT_NEAR(static_cast<double>(states.wanted()), 750.0, 1.0);
}

TEST(SentStates, EmptyHandOwesNoState) {
  SentStates states;
  for (int i = 0; i < 100; ++i) states.Add(1000 * kMs + i * kMs, kMs);
  for (int i = 0; i < 100; ++i) states.Add(9000 * kMs + i * kMs, kMs);
  EXPECT_EQ(states.wanted(), 200U);
}

}  // namespace
}  // namespace tandem
