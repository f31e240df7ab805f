#include "app/bench/fidelity/push_judge.h"

#include <cmath>

#include <gtest/gtest.h>

#include "app/bench/fidelity/force_steps.h"
#include "tests/support/shapes.h"

// Places on boxes and directions off them are known without any search.

namespace tandem {
namespace {

using testing::At;
using testing::Box;

constexpr double kSlabVoxel = 0.001;  // m
const Vec3 kUp = Vec3::UnitZ();
/// A slab whose upper face is z = 0 and whose edge to +x is at x = 0.05.
const TriangleMesh kSlab = At(Box(Vec3(0.1, 0.1, 0.01)), Vec3(0, 0, -0.005));
const TriangleMesh kCube = Box(Vec3::Constant(0.01));

/// Returns the pose of a cube over the slab whose lower face is that high above it.
Pose CubeAt(double voxels) {
  return {Quat::Identity(), Vec3(0.003, 0.002, 0.005 + voxels * kSlabVoxel)};
}

Vec3 Rotated(double degrees, const Vec3& way) {
  return RotationBy(degrees * M_PI / 180 * Vec3::UnitX()) * way;
}

TEST(PushJudge, MeasuresFaceDistanceOnEitherBody) {
  const PushJudge judge(kSlab, kCube, kSlabVoxel);
  for (const double voxels : {0.01, 0.3, 0.9}) {
    const Pose X_WB = CubeAt(voxels);
    for (const Vec3& p_W : {X_WB * Vec3(0.001, 0.002, -0.005), Vec3(0.004, 0.004, 0)}) {
      const JudgedPush up = judge.Judge(p_W, kUp, X_WB);
      EXPECT_NEAR(up.distance_voxels, voxels, 1e-9);
      EXPECT_NEAR(up.askew_deg, 0, 1e-5);
      EXPECT_NEAR(judge.Judge(p_W, Rotated(17, kUp), X_WB).askew_deg, 17, 1e-5);
      EXPECT_NEAR(judge.Judge(p_W, -kUp, X_WB).askew_deg, 180, 1e-5);
    }
  }
}

// The slab's upper face is two triangles. Beside their common edge, a diagonal, the triangle that
// is a little farther gives no direction of its own.
TEST(PushJudge, RejectsEdgeDirectionsWhenAFaceIsNearer) {
  const PushJudge judge(kSlab, kCube, kSlabVoxel);
  for (const double diagonal : {-1.0, 1.0}) {
    for (const double beside : {-0.05, 0.05}) {
      const Vec3 p_W =
          Vec3(0.003, diagonal * 0.003, 0.3 * kSlabVoxel) + beside * kSlabVoxel * Vec3::UnitX();
      const Pose X_WB{Quat::Identity(), p_W + Vec3::Constant(0.005)};
      for (const double turn : {-8.0, 8.0}) {
        const Vec3 along = Vec3(1, diagonal, 0).normalized();
        const Vec3 way = RotationBy(turn * M_PI / 180 * along) * kUp;
        EXPECT_NEAR(judge.Judge(p_W, way, X_WB).askew_deg, 8, 1e-5);
      }
    }
  }
}

// The way leads out of the solid, however deep a place is in it.
TEST(PushJudge, FindsTheWayOutOfASolid) {
  const PushJudge judge(kSlab, kCube, kSlabVoxel);
  const Pose X_WB = CubeAt(-0.4);
  const JudgedPush up = judge.Judge(X_WB * Vec3(0.001, 0.002, -0.005), kUp, X_WB);
  EXPECT_NEAR(up.distance_voxels, 0.4, 1e-9);
  EXPECT_NEAR(up.askew_deg, 0, 1e-5);
}

// The place is as far out beside an edge as up, so the way off is the diagonal and no face's
// normal.
TEST(PushJudge, AcceptsEdgeDirectionsWhenTheEdgeIsNearest) {
  const PushJudge judge(kSlab, kCube, kSlabVoxel);
  const Vec3 p_W(0.05 + 0.2 * kSlabVoxel, 0.003, 0.2 * kSlabVoxel);
  // the cube's lower corner stands there
  const Pose X_WB{Quat::Identity(), p_W + Vec3::Constant(0.005)};
  const Vec3 aslant = Vec3(1, 0, 1).normalized();
  EXPECT_NEAR(judge.Judge(p_W, aslant, X_WB).askew_deg, 0, 1e-5);
  EXPECT_NEAR(judge.Judge(p_W, aslant, X_WB).distance_voxels, 0.2 * std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(judge.Judge(p_W, kUp, X_WB).askew_deg, 45, 1e-5);
}

// In the corner of a slab and a wall upon it both push, and so does any direction between theirs.
TEST(PushJudge, AcceptsDirectionsBetweenEquallyNearFaces) {
  TriangleMesh notch = kSlab;
  Append(notch, At(Box(Vec3(0.01, 0.1, 0.02)), Vec3(-0.005, 0, 0.0099)));  // its face: x = 0
  const PushJudge judge(notch, kCube, kSlabVoxel);
  const auto askew = [&](double from_wall, double height, const Vec3& way) {
    const Vec3 p_W(from_wall * kSlabVoxel, 0.003, height * kSlabVoxel);
    return judge.Judge(p_W, way, {Quat::Identity(), p_W + Vec3::Constant(0.005)}).askew_deg;
  };
  for (const Vec3& way : {Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(1, 0, 2), Vec3(3, 0, 1)}) {
    EXPECT_NEAR(askew(0.300, 0.310, way.normalized()), 0, 1e-5) << way.transpose();
  }
  EXPECT_NEAR(askew(0.300, 0.310, Rotated(25, kUp)), 25, 1e-4);
  // the slab alone is near
  EXPECT_NEAR(askew(0.4, 0.3, kUp), 0, 1e-5);
  EXPECT_NEAR(askew(0.4, 0.3, Vec3::UnitX()), 90, 1e-5);
}

// The angles are of spherical trigonometry: from a side of a square cone, and from its corner.
TEST(AngleFromCone, IsMeasuredFromTheNearestSideOrEdge) {
  const std::vector<Vec3> quadrant{Vec3::UnitX(), Vec3::UnitY(), kUp};
  EXPECT_NEAR(AngleFromCone(Vec3(1, 2, 3).normalized(), quadrant), 0, 1e-6);
  EXPECT_NEAR(AngleFromCone(Rotated(30, kUp), quadrant), 30, 1e-6);
  EXPECT_NEAR(AngleFromCone(Vec3(1, 1, -std::sqrt(2.0)).normalized(), quadrant), 45, 1e-6);
  EXPECT_NEAR(AngleFromCone(-kUp, {kUp}), 180, 1e-6);
}

TEST(FalsePushes, CountsEachFaultAndWhatForceItHas) {
  FalsePushes pushes;
  pushes.Count({.distance_voxels = 0.4, .askew_deg = 9}, 3.0);
  pushes.Count({.distance_voxels = 0.7, .askew_deg = 9}, 2.0);
  pushes.Count({.distance_voxels = 0.4, .askew_deg = 11}, 4.0);
  pushes.Count({.distance_voxels = 0.7, .askew_deg = 11}, 1.0);
  EXPECT_EQ(pushes.contacts, 4U);
  EXPECT_EQ(pushes.farther, 2U);
  EXPECT_EQ(pushes.askew, 2U);
  EXPECT_DOUBLE_EQ(pushes.force_share(), 0.7);  // 7 N of 10
}

// A slope of 50 N over a 64th part of the way that is halved 20 times leaves less than a millionth
// of a newton.
TEST(LargestForceStep, DetectsJumpsAndIgnoresSlopes) {
  for (const double jump : {0.0, 3.0}) {
    const auto force_at = [jump](double share) {
      return Vec3(50 * share, share > 0.3137 ? jump : 0.0, 0);
    };
    EXPECT_NEAR(LargestForceStep(force_at, 64, 0), jump, 1e-6);
    EXPECT_NEAR(LargestForceStep(force_at, 64, 5), 5, 1e-6) << "a larger one is known";
  }
}

}  // namespace
}  // namespace tandem
