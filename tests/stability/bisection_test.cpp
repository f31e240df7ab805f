#include "collab/lab/run/bisection.h"

#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>

#include "tests/stability/free_box.h"

namespace tandem {
namespace {

using testing::FreeBox;
using testing::HandOfBox;

/// Returns a case with 10 N s/m against the ground, whatever the stiffness.
LabCase Constant(const std::string& hand, double delay_s) {
  LabCase test;
  test.hands = {HandOfBox(hand)};
  test.law.name = "constant";
  test.law.limits.constant_damping = 10;
  test.law.gate = false;
  test.delay_s = delay_s;
  test.seconds = delay_s > 0.3 ? 300 * delay_s : 40;
  return test;
}

struct Row {
  const char* hand;
  double delay_s;
  double ratio;  // boundary of hand, coupling and body in steps of 1 ms, by eigenvalues
};

// TANDEM_STABILITY=1 adds a delay of 1 s.
TEST(FindBoundary, MatchesTheEigenvaluesOfTheWholeChain) {
  const bool whole = std::getenv("TANDEM_STABILITY") != nullptr;
  for (const Row& row :
       {Row{"off", 0.1, 1.023}, Row{"off", 0.3, 1.009}, Row{"off", 1.0, 1.010},
        Row{"heavy", 0.1, 1.158}, Row{"heavy", 0.3, 1.021}, Row{"heavy", 1.0, 1.007}}) {
    if (row.delay_s > 0.3 && !whole) continue;
    SCOPED_TRACE(std::string(row.hand) + " at " + std::to_string(row.delay_s) + " s");
    const BoundaryPoint point = FindBoundary(Constant(row.hand, row.delay_s), FreeBox());
    ASSERT_FALSE(point.fault) << point.fault->what;
    EXPECT_NEAR(point.ratio(), row.ratio, 0.03 * row.ratio);
    EXPECT_LE(point.runs, 14);
  }
}

// A case on which theory is silent is named, not run.
TEST(FindBoundary, ReportsAMissingBoundary) {
  LabCase exchanged = Constant("off", 0.1);
  exchanged.law.exchange_forces = true;
  EXPECT_TRUE(FindBoundary(exchanged, FreeBox()).fault);
  LabCase soft = Constant("off", 0.1);
  soft.law.limits.constant_stiffness = 0;
  EXPECT_TRUE(FindBoundary(soft, FreeBox()).fault);
}

}  // namespace
}  // namespace tandem
