#include "engine/voxel/points/pointshell.h"

#include <array>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "engine/voxel/build/voxelize.h"
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

TEST(Pointshell, IsInTheBodysFrame) {
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

TEST(Pointshell, ThinPlatesGetAPointPerSide) {
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

// Finds the distances of all pairs in voxels that share a face, with every point really moved. If a
// voxel has several points, the nearest counts.
double GapByPairs(const Pointshell& shell, double displacement) {
  const double s = shell.spacing;
  std::map<std::array<int, 3>, std::vector<std::size_t>> voxels;
  std::vector<std::array<int, 3>> place;
  for (std::size_t i = 0; i < shell.size(); ++i) {
    std::array<int, 3> voxel{};
    for (int k = 0; k < 3; ++k) {
      voxel[static_cast<std::size_t>(k)] = static_cast<int>(std::floor(shell.point(i)[k] / s));
    }
    voxels[voxel].push_back(i);
    place.push_back(voxel);
  }
  double gap = 0;
  for (std::size_t i = 0; i < shell.size(); ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::array<int, 3> next = place[i];
      ++next[axis];
      if (!voxels.contains(next)) continue;
      double nearest = 1e9;
      for (const std::size_t j : voxels[next]) {
        nearest = std::min(nearest, (shell.point(j) + displacement * shell.normal(j) -
                                     shell.point(i) - displacement * shell.normal(i))
                                        .norm());
      }
      gap = std::max(gap, nearest);
    }
  }
  return gap;
}

TEST(Pointshell, ReportsNeighbourSpacingUnderDisplacement) {
  std::mt19937_64 random(8);
  const double s = 0.01;
  TriangleMesh plate = Box(Vec3(0.3, 0.3, 0.002));  // both sides in one voxel
  for (Vec3& v : plate.vertices) v += Vec3(0, 0, 0.005);
  for (const TriangleMesh& mesh :
       {Sphere(0.08, 4), plate,
        Transformed(Box(Vec3(0.2, 0.1, 0.15)), {RandomRotation(random), Vec3::Zero()})}) {
    const Pointshell shell = MustMake(mesh, Pose{}, {.spacing = s});
    EXPECT_DOUBLE_EQ(shell.GapWhenDisplaced(0), s);
    for (const double voxels : {-1.0, -0.5, -0.25, 0.25, 0.75, 1.0}) {
      EXPECT_NEAR(shell.GapWhenDisplaced(voxels * s), GapByPairs(shell, voxels * s), 1e-6)
          << voxels;
    }
    // between two steps by the line through them, which is above the curve
    const double between = shell.GapWhenDisplaced(-0.6 * s) - GapByPairs(shell, -0.6 * s);
    EXPECT_GE(between, -1e-6);
    EXPECT_LE(between, 0.05 * s);
  }
  // a ball's points part outwards, by its radius, and close up inwards
  const Pointshell ball = MustMake(Sphere(0.08, 5), Pose{}, {.spacing = s});
  EXPECT_GT(ball.GapWhenDisplaced(-s), 1.05 * s);
  EXPECT_LT(ball.GapWhenDisplaced(s), 1.05 * s);
  // displaced already, and some more
  const Pointshell shifted =
      MustMake(Sphere(0.08, 5), Pose{}, {.spacing = s, .inward_shift = -0.5 * s});
  EXPECT_NEAR(shifted.GapWhenDisplaced(-0.5 * s), ball.GapWhenDisplaced(-s), 1e-9);
}

TEST(Pointshell, ChunkSpheresContainTheirPoints) {
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

// The k-th free layer is every voxel outside whose nearest surface voxel is k away by chess-board.
TEST(Pointshell, FreeLayerHasAPointPerVoxelAtItsDistance) {
  constexpr double kS = 0.02;
  const Vec3 size(0.19, 0.13, 0.11);
  const auto cell_of = [&](const Pointshell& shell, std::size_t i) -> std::array<int, 3> {
    const Vec3 cell = (shell.point(i) / kS).array().floor();
    return {static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())};
  };
  const Pointshell surface = MustMake(Box(size), Pose{}, {.spacing = kS});
  for (const int k : {1, 2, 3}) {
    const Pointshell layer = MustMake(Box(size), Pose{}, {.spacing = kS, .free_layer = k});
    std::set<std::array<int, 3>> found;
    for (std::size_t i = 0; i < layer.size(); ++i) {
      found.insert(cell_of(layer, i));
      EXPECT_LT(layer.normal(i).dot(layer.point(i)), 0) << "it points into the body";
    }
    EXPECT_EQ(found.size(), layer.size()) << "one point a voxel";
    std::set<std::array<int, 3>> wanted;
    for (int x = -10; x < 10; ++x) {
      for (int y = -10; y < 10; ++y) {
        for (int z = -10; z < 10; ++z) {
          const Vec3 over = (kS * Vec3(x + 0.5, y + 0.5, z + 0.5)).cwiseAbs() - 0.5 * size;
          if (over.maxCoeff() < 0) continue;
          int nearest = 100;
          for (std::size_t i = 0; i < surface.size(); ++i) {
            const auto at = cell_of(surface, i);
            nearest = std::min(
                nearest, std::max({std::abs(at[0] - x), std::abs(at[1] - y), std::abs(at[2] - z)}));
          }
          if (nearest == k) wanted.insert({x, y, z});
        }
      }
    }
    EXPECT_EQ(found, wanted) << "layer " << k;
  }
}

TEST(Pointshell, RefusesMeshesWithoutArea) {
  TriangleMesh flat = Sheet(1.0);
  for (Vec3& v : flat.vertices) v = Vec3(1, 1, 1);
  EXPECT_FALSE(MakePointshell(flat, Pose{}, {.spacing = 0.1}));
  EXPECT_FALSE(MakePointshell(TriangleMesh{}, Pose{}, {.spacing = 0.1}));
}

}  // namespace
}  // namespace tandem
