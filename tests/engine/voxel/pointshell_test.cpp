#include "engine/voxel/pointshell.h"

#include <gtest/gtest.h>

#include "engine/voxel/voxelize.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Box;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Sheet;
using testing::Sphere;

Pointshell MustMake(const TriangleMesh& mesh, const Pose& X_WB, const PointshellOptions& options) {
  Result<Pointshell> made = MakePointshell(mesh, X_WB, options);
  EXPECT_TRUE(made) << (made ? "" : made.error().what);
  return std::move(*made);
}

TEST(Pointshell, HasOnePointForEverySurfaceVoxelAtItsCentre) {
  const TriangleMesh sphere = Sphere(0.5, 4);
  const Pointshell shell = MustMake(sphere, Pose{}, {.spacing = 0.02});
  const VoxelCounts counts = Voxelize(sphere, {.voxel_size = 0.02})->Count();
  EXPECT_EQ(shell.size(), counts.surface);
  for (std::size_t i = 0; i < shell.size(); ++i) {
    const Vec3 cell = shell.point(i) / 0.02 - Vec3::Constant(0.5);
    EXPECT_NEAR((cell - cell.array().round().matrix()).norm(), 0.0, 1e-4);
  }
}

// On a sphere the inward normal points to the centre; a voxel's facets spread over s/R radians.
TEST(Pointshell, NormalsPointIntoTheBody) {
  const Pose X_WB{Quat::Identity(), Vec3(1, 2, 3)};
  const Pointshell shell = MustMake(Transformed(Sphere(0.5, 5), X_WB), X_WB, {.spacing = 0.02});
  for (std::size_t i = 0; i < shell.size(); ++i) {
    EXPECT_NEAR(shell.normal(i).norm(), 1.0, 1e-6);
    EXPECT_GT(shell.normal(i).dot(-shell.point(i).normalized()), std::cos(0.08));
  }
}

TEST(Pointshell, StandsInTheBodysFrame) {
  std::mt19937_64 random(4);
  const Pose X_WB{RandomRotation(random), 0.3 * RandomDirection(random)};
  const TriangleMesh box = Transformed(Box(Vec3(0.3, 0.2, 0.1)), X_WB);
  const Pointshell shell = MustMake(box, X_WB, {.spacing = 0.005});
  for (std::size_t i = 0; i < shell.size(); ++i) {
    const Vec3 over = shell.point(i).cwiseAbs() - Vec3(0.15, 0.1, 0.05);
    EXPECT_LT(over.maxCoeff(), 0.005 * 0.867);  // within half a voxel's diagonal of the surface
    EXPECT_GT(over.maxCoeff(), -0.005 * 0.867);
  }
  EXPECT_NEAR(shell.radius, Vec3(0.15, 0.1, 0.05).norm(), 0.005);
}

TEST(Pointshell, ThinPlatesGetAPointForEachSide) {
  // 0.2 voxels thick and within one layer of voxels
  TriangleMesh plate = Box(Vec3(0.5, 0.5, 0.002));
  for (Vec3& v : plate.vertices) v += Vec3(0, 0, 0.005);
  const Pointshell shell = MustMake(plate, Pose{}, {.spacing = 0.01});
  std::size_t up = 0;
  std::size_t down = 0;
  for (std::size_t i = 0; i < shell.size(); ++i) {
    up += shell.normal(i).z() > 0.99;
    down += shell.normal(i).z() < -0.99;
  }
  EXPECT_GE(up, 48U * 48);
  EXPECT_GE(down, 48U * 48);
}

TEST(Pointshell, ShiftsAlongItsInwardNormals) {
  const Pointshell plain = MustMake(Sphere(0.5, 4), Pose{}, {.spacing = 0.02});
  const Pointshell shifted =
      MustMake(Sphere(0.5, 4), Pose{}, {.spacing = 0.02, .inward_shift = 0.01});
  ASSERT_EQ(plain.size(), shifted.size());
  for (std::size_t i = 0; i < plain.size(); ++i) {
    EXPECT_NEAR((shifted.point(i) - plain.point(i) - 0.01 * plain.normal(i)).norm(), 0.0, 1e-6);
  }
}

TEST(Pointshell, ChunksHoldTheirPointsInTheirBalls) {
  const Pointshell shell = MustMake(Sphere(0.5, 4), Pose{}, {.spacing = 0.02});
  std::size_t counted = 0;
  for (const Pointshell::Chunk& chunk : shell.chunks) {
    EXPECT_EQ(chunk.first, counted);
    counted += chunk.count;
    EXPECT_LE(chunk.radius, 4 * std::sqrt(3.0) * 0.02 + 1e-6);
    for (std::size_t i = chunk.first; i < chunk.first + chunk.count; ++i) {
      EXPECT_LE((shell.point(i) - chunk.p_BC).norm(), chunk.radius + 1e-9);
    }
  }
  EXPECT_EQ(counted, shell.size());
}

TEST(Pointshell, RefusesMeshesWithoutArea) {
  TriangleMesh flat = Sheet(1.0);
  for (Vec3& v : flat.vertices) v = Vec3(1, 1, 1);
  EXPECT_FALSE(MakePointshell(flat, Pose{}, {.spacing = 0.1}));
  EXPECT_FALSE(MakePointshell(TriangleMesh{}, Pose{}, {.spacing = 0.1}));
}

}  // namespace
}  // namespace tandem
