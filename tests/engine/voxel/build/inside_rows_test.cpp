#include "engine/voxel/build/inside_rows.h"

#include <array>
#include <random>

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

Voxmap RowsVoxelized(const TriangleMesh& mesh, double s, int range = kDefaultRange) {
  Result<Voxmap> made = Voxelize(mesh, {.voxel_size = s, .range = range});
  EXPECT_TRUE(made) << (made ? "" : made.error().what);
  return std::move(*made);
}

/// The planes of a convex mesh with outward faces.
struct ConvexPlanes {
  explicit ConvexPlanes(const TriangleMesh& mesh) {
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Vec3 n = (mesh.corner(t, 1) - mesh.corner(t, 0))
                         .cross(mesh.corner(t, 2) - mesh.corner(t, 0))
                         .normalized();
      planes.push_back({n.x(), n.y(), n.z(), n.dot(mesh.corner(t, 0))});
    }
  }
  bool Contains(double x, double y, double z) const {
    for (const auto& [nx, ny, nz, d] : planes) {
      if (nx * x + ny * y + nz * z >= d) return false;
    }
    return true;
  }
  std::vector<std::array<double, 4>> planes;
};

void ExpectInteriorExactly(const TriangleMesh& mesh, double s) {
  const Voxmap voxmap = RowsVoxelized(mesh, s);
  const Bounds box = BoundsOf(mesh);
  const ConvexPlanes planes(mesh);
  long inside = 0;
  for (auto z = static_cast<int>(std::floor(box.min.z() / s)) - 12; z <= box.max.z() / s + 12;
       ++z) {
    for (auto y = static_cast<int>(std::floor(box.min.y() / s)) - 12; y <= box.max.y() / s + 12;
         ++y) {
      for (auto x = static_cast<int>(std::floor(box.min.x() / s)) - 12; x <= box.max.x() / s + 12;
           ++x) {
        const int value = voxmap.Value(Field::kSurface, GridIndex{x, y, z} - voxmap.origin());
        if (value == kSurfaceMark) continue;
        const bool expected = planes.Contains(s * (x + 0.5), s * (y + 0.5), s * (z + 0.5));
        ASSERT_EQ(value == kInteriorMark, expected) << x << " " << y << " " << z;
        inside += expected;
      }
    }
  }
  EXPECT_GT(inside, 1000);
}

TEST(Interior, IsExactForTiltedBoxesAndSpheres) {
  std::mt19937_64 random(3);
  for (int trial = 0; trial < 5; ++trial) {
    TriangleMesh box = Box(Vec3(1.0, 0.8, 1.4));
    TriangleMesh sphere = Sphere(0.7, 2);
    const Pose X{RandomRotation(random), 3.0 * RandomDirection(random)};
    ExpectInteriorExactly(Transformed(box, X), 0.04);
    ExpectInteriorExactly(Transformed(sphere, X), 0.05);
  }
}

// Rays through voxel centres run exactly along edges and through vertices here.
TEST(Interior, IsExactWhenEdgesLieOnTheRays) {
  const double s = 0.1;
  TriangleMesh box = Box(Vec3(2.0, 2.0, 2.0));
  for (Vec3& v : box.vertices) v += Vec3::Constant(0.5 * s);
  ExpectInteriorExactly(box, s);
}

// Chunks and hyperchunks deep inside carry no marks and must still read as interior.
TEST(Interior, UnstoredInteriorReadsAsInterior) {
  const Voxmap voxmap = RowsVoxelized(Box(Vec3(3.0, 3.0, 3.0)), 0.01);
  const GridIndex centre = GridIndex{0, 0, 0} - voxmap.origin();
  EXPECT_EQ(voxmap.Value(Field::kSurface, centre), kInteriorMark);
  EXPECT_EQ(voxmap.Value(Field::kSurface, centre + GridIndex{100, -90, 30}), kInteriorMark);
  EXPECT_EQ(voxmap.Value(Field::kSurface, centre + GridIndex{190, 0, 0}), voxmap.beyond());
  EXPECT_EQ(voxmap.Value(Field::kSurface, centre + GridIndex{100000, 0, 0}), voxmap.beyond());
  EXPECT_EQ(voxmap.Value(Field::kSurface, GridIndex{-1, 0, 0}), voxmap.beyond());
}

TEST(Interior, OverlappingBodiesAreSolidAndCavitiesEmpty) {
  const double s = 0.05;
  TriangleMesh overlapping = Box(Vec3(2, 2, 2));
  TriangleMesh second = Box(Vec3(2, 2, 2));
  for (Vec3& v : second.vertices) v += Vec3(1.0, 0.013, 0.017);
  Append(overlapping, second);
  const Voxmap both = RowsVoxelized(overlapping, s);
  EXPECT_EQ(both.Value(Field::kSurface, GridIndex{10, 3, 3} - both.origin()), kInteriorMark);

  TriangleMesh hollow = Box(Vec3(2, 2, 2));
  TriangleMesh cavity = Box(Vec3(1, 1, 1));
  for (auto& t : cavity.triangles) std::swap(t[1], t[2]);
  Append(hollow, cavity);
  const Voxmap shell = RowsVoxelized(hollow, s);
  EXPECT_EQ(shell.Value(Field::kSurface, GridIndex{5, 0, 0} - shell.origin()),
            2 + 5);  // its wall is at voxel 10
  EXPECT_EQ(shell.Value(Field::kSurface, GridIndex{15, 0, 0} - shell.origin()), kInteriorMark);
}

// Where two arms of one body cross it is solid, though a ray there goes in twice.
TEST(Interior, SelfIntersectionIsSolid) {
  TriangleMesh arms = Box(Vec3(2, 1, 1));
  TriangleMesh other = Box(Vec3(1, 2, 1.001));
  Append(arms, other);
  // one vertex of the second is that of the first: by connection they are one body
  TriangleMesh joined = arms;
  for (auto& t : joined.triangles) {
    for (auto& v : t) v = v == 8 ? 0 : v;
  }
  const Voxmap voxmap = RowsVoxelized(joined, 0.05);
  EXPECT_EQ(voxmap.Value(Field::kSurface, GridIndex{3, 3, 3} - voxmap.origin()), kInteriorMark);
}

// One triangle in fifty is missing, and some are wound the wrong way: only the holes are fuzzy.
TEST(Interior, SphereWithHolesAndFlippedTrianglesIsNearlySolid) {
  const double s = 0.04;
  const TriangleMesh sphere = Sphere(1.0, 4);
  TriangleMesh torn = sphere;
  std::mt19937_64 random(9);
  torn.triangles.clear();
  for (TriangleMesh::Triangle t : sphere.triangles) {
    if (random() % 50 == 0) continue;
    if (random() % 50 == 0) std::swap(t[1], t[2]);
    torn.triangles.push_back(t);
  }
  const Voxmap whole = RowsVoxelized(sphere, s);
  const Voxmap mended = RowsVoxelized(torn, s);
  long inside = 0;
  long wrong = 0;
  for (int z = -30; z < 30; ++z) {
    for (int y = -30; y < 30; ++y) {
      for (int x = -30; x < 30; ++x) {
        const GridIndex i{x, y, z};
        const int expected = whole.Value(Field::kSurface, i - whole.origin());
        if (expected == kSurfaceMark) continue;
        const int value = mended.Value(Field::kSurface, i - mended.origin());
        inside += expected == kInteriorMark;
        wrong += (value == kInteriorMark) != (expected == kInteriorMark);
      }
    }
  }
  EXPECT_GT(inside, 50000);
  EXPECT_LT(wrong, inside / 80);
}

TEST(Interior, OpenSheetsHaveNoInterior) {
  const Voxmap voxmap = RowsVoxelized(Sheet(1.0), 0.02);
  const VoxelCounts counts = voxmap.Count();
  EXPECT_EQ(counts.interior, 0U);
  EXPECT_GE(counts.surface, 50U * 50);
}

}  // namespace
}  // namespace tandem
