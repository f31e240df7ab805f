#include "app/judgement/exact_depth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/solid_meshes.h"

namespace tandem {
namespace {

using testing::BoxBetween;
using testing::BoxOfHalf;
using testing::GlobeMesh;

constexpr double kTolerance = 1e-6;  // m

/// A plate whose upper face is at z = 0.
ExactSurface Plate() {
  return ExactSurface(BoxBetween({-1, -1, -0.5}, {1, 1, 0}));
}

TEST(GreatestDepth, IsThatOfTheLowestCornerOfATiltedBox) {
  const Quat q = RotationBy(Vec3(0.3, -0.2, 0.5));
  const TriangleMesh box = BoxOfHalf({0.1, 0.1, 0.1});
  const Pose X_FB{q, Vec3(0.02, 0.01, 0.12)};
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vec3& corner : box.vertices) lowest = std::min(lowest, (X_FB * corner).z());
  ASSERT_LT(lowest, 0);
  const BoundedDepth found = GreatestDepth(Plate(), box, X_FB, 0, kTolerance);
  EXPECT_NEAR(found.depth, -lowest, kTolerance);
  EXPECT_LE(found.error, kTolerance);
  EXPECT_GE(found.depth + found.error, -lowest - 1e-12);
}

// Everywhere on the face the depth is the same.
TEST(GreatestDepth, OfAFaceOnAFaceIsFoundWithoutManyLooks) {
  const BoundedDepth found =
      GreatestDepth(Plate(), BoxOfHalf({0.3, 0.3, 0.1}), {Quat::Identity(), Vec3(0, 0, 0.06)}, 0,
                    kTolerance, 2000);
  EXPECT_NEAR(found.depth, 0.04, kTolerance);
  EXPECT_LE(found.error, kTolerance);
}

// A thin wedge of a box lies deepest in the middle of a wall, where no corner of it is.
TEST(GreatestDepth, LiesBetweenCornersWhereAWallIsThin) {
  const ExactSurface wall(BoxBetween({-0.01, -1, -1}, {0.01, 1, 1}));
  const BoundedDepth found = GreatestDepth(wall, BoxOfHalf({0.3, 0.02, 0.02}),
                                           {Quat::Identity(), Vec3(0.013, 0, 0)}, 0, kTolerance);
  // halfway between two walls the bound closes in by small steps
  EXPECT_LE(found.depth, 0.01 + 1e-12);
  EXPECT_GE(found.depth + found.error, 0.01 - 1e-12);
  EXPECT_LE(found.error, 2e-4);
}

TEST(GreatestDepth, OfABallInABallIsTheirOverlap) {
  const TriangleMesh ball = GlobeMesh(0.1, 48);
  const BoundedDepth found =
      GreatestDepth(ExactSurface(ball), ball, {Quat::Identity(), Vec3(0.19, 0, 0)}, 0, 1e-5);
  // facets lie up to a thousandth of the radius inside
  EXPECT_NEAR(found.depth, 0.01, 6e-4);
  EXPECT_LE(found.error, 1e-5);
}

// A tongue fits a groove with a gap of 60 um at one wall, and lies 30 um deep in the other. Its
// pieces in the gap are nearer to a wall than the error that is asked.
TEST(GreatestDepth, IsBoundedAsWellBesideAGapBetweenParallelWalls) {
  TriangleMesh groove = BoxBetween({-0.02, -0.05, -0.05}, {0, 0.05, 0.05});
  Append(groove, BoxBetween({0.01003, -0.05, -0.05}, {0.03, 0.05, 0.05}));
  const BoundedDepth found =
      GreatestDepth(ExactSurface(groove), BoxBetween({0, -0.02, -0.02}, {0.01, 0.02, 0.02}),
                    {Quat::Identity(), Vec3(-30e-6, 0, 0)}, 0, 1e-6, 10'000);
  EXPECT_NEAR(found.depth, 30e-6, 1e-6);
  EXPECT_LE(found.error, 1e-6);
}

TEST(GreatestDepth, IsNoneWhereNothingOverlaps) {
  const BoundedDepth found = GreatestDepth(Plate(), BoxOfHalf({0.3, 0.3, 0.1}),
                                           {Quat::Identity(), Vec3(0, 0, 0.1001)}, 0, 1e-9, 200);
  EXPECT_EQ(found.depth, 0);
  EXPECT_EQ(found.error, 0);
}

TEST(GreatestDepth, NamesItsErrorWhereTheLooksRunOut) {
  const TriangleMesh ball = GlobeMesh(0.1, 48);
  const ExactSurface fixture(ball);
  const Pose X_FB{Quat::Identity(), Vec3(0.19, 0.003, 0.002)};
  const double exact = GreatestDepth(fixture, ball, X_FB, 0, 1e-6, 200'000).depth;
  const BoundedDepth rough = GreatestDepth(fixture, ball, X_FB, 0, 1e-6, ball.triangles.size());
  EXPECT_LE(rough.depth, exact + 1e-6);
  EXPECT_GE(rough.depth + rough.error, exact);
  EXPECT_EQ(GreatestDepth(fixture, ball, X_FB, 0.002, 1e-6, 10).depth, 0.002);
  EXPECT_TRUE(std::isinf(GreatestDepth(fixture, ball, X_FB, 0.002, 1e-6, 10).error));
}

}  // namespace
}  // namespace tandem
