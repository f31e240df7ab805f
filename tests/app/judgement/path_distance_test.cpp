#include "app/judgement/path_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/support/key_scene.h"
#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using testing::BoxBetween;
using testing::BoxOfHalf;

constexpr double kPathMillimetre = 1e-3;  // m

// A cube over a plate with far edges is as far from it as its lowest corner is high.
TEST(PathDistance, MatchesARotatingCubeWithFewSearches) {
  const TriangleMesh plate = BoxBetween({-1, -1, -0.02}, {1, 1, 0});
  const TriangleMesh cube = Transformed(BoxOfHalf(Vec3::Constant(10 * kPathMillimetre)),
                                        {Quat::Identity(), Vec3(0, 0, 50 * kPathMillimetre)});
  const auto model = testing::MakeWorldModel({{plate, true}, {cube}}, 5 * kPathMillimetre);
  const Quat& q_WB0 = model->bodies[0].X_WB0.q;
  PathDistance path(std::make_shared<const PathMeshes>(model));
  double least = std::numeric_limits<double>::infinity();
  constexpr int kFrames = 4000;
  for (int i = 0; i < kFrames; ++i) {
    const double t = 1e-3 * i;
    // in the second half it only turns, from standing flat onto a corner: each pose is the nearest
    if (i == kFrames / 2) {
      EXPECT_LT(path.searches(), kFrames / 4U);
    }
    const bool only_turns = i >= kFrames / 2;
    const Quat turn = RotationBy(only_turns ? Vec3(0.3 * (t - 2), 0.3 * (t - 2), 0)
                                            : Vec3(0.9 * std::sin(3 * t), std::cos(2 * t), 2 * t));
    const Vec3 centre = only_turns
                            ? Vec3(0, 0, 0.022)
                            : Vec3(0.1 * std::sin(t), 0.1 * t, 0.06 + 0.03 * std::cos(5 * t));
    path.See(0, {{turn * q_WB0, centre}}, i);
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 p_B((corner & 1) != 0 ? 10 * kPathMillimetre : -10 * kPathMillimetre,
                     (corner & 2) != 0 ? 10 * kPathMillimetre : -10 * kPathMillimetre,
                     (corner & 4) != 0 ? 10 * kPathMillimetre : -10 * kPathMillimetre);
      least = std::min(least, (turn * p_B).z() + centre.z());
    }
    ASSERT_NEAR(path.nearest().distance, least, 1e-12) << "frame " << i;
  }
  EXPECT_GT(least, 0);
}

// Two cubes on one line: the gap between their faces, whichever of them moves.
TEST(PathDistance, CountsTheMotionOfBothBodies) {
  const TriangleMesh cube = BoxOfHalf(Vec3::Constant(10 * kPathMillimetre));
  const TriangleMesh beside =
      Transformed(cube, {Quat::Identity(), Vec3(50 * kPathMillimetre, 0, 0)});
  const auto model = testing::MakeWorldModel({{cube}, {beside}}, 5 * kPathMillimetre);
  PathDistance path(std::make_shared<const PathMeshes>(model));
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 1000; ++i) {
    // in the second half the other one moves alone
    const double x = i < 500 ? 10 * kPathMillimetre * std::sin(0.01 * i) : 12 * kPathMillimetre;
    const double other_x = 50 * kPathMillimetre - 15 * kPathMillimetre * std::sin(0.013 * i);
    path.See(0,
             {{model->bodies[0].X_WB0.q, Vec3(x, 0, 0)},
              {model->bodies[1].X_WB0.q, Vec3(other_x, 0, 0)}},
             i);
    least = std::min(least, other_x - x - 20 * kPathMillimetre);
    ASSERT_NEAR(path.nearest().distance, least, 1e-12) << "frame " << i;
  }
  EXPECT_EQ(path.nearest().other, 1);
}

}  // namespace
}  // namespace tandem
