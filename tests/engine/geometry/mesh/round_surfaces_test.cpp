#include "engine/geometry/mesh/round_surfaces.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace tandem {
namespace {

constexpr RoundSurfaceRules kRules{
    .most_sagitta = 0.25e-3, .most_off = 0.01e-3, .least_radius = 1e-3};

TEST(RoundSurfaces, FindsABallWithItsCentreAndRadius) {
  const Vec3 centre(0.03, -0.02, 0.5);
  const auto found = FindRoundSurfaces(testing::At(testing::Sphere(0.01, 4), centre), kRules);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].is_sphere());
  EXPECT_LT((found[0].centre - centre).norm(), 1e-9);
  EXPECT_NEAR(found[0].radius, 0.01, 1e-9);
}

TEST(RoundSurfaces, ABoxHasNone) {
  EXPECT_TRUE(FindRoundSurfaces(testing::Box(Vec3(0.02, 0.03, 0.01)), kRules).empty());
}

// An octahedron's corners lie on a sphere too, but it does not roll like one.
TEST(RoundSurfaces, ACoarseSolidIsNoBall) {
  EXPECT_TRUE(FindRoundSurfaces(testing::Sphere(0.01, 1), kRules).empty());
}

}  // namespace
}  // namespace tandem
