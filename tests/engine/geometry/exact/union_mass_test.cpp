#include "engine/geometry/exact/union_mass.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/engine/geometry/shapes.h"

namespace tandem {
namespace {

using testing::BoxMesh;
using testing::MovedBy;
using testing::SphereMesh;

TriangleMesh Both(TriangleMesh a, const TriangleMesh& b) {
  Append(a, b);
  return a;
}

/// Expects the distribution of a cuboid of this size and centre.
void ExpectCuboid(const MassProperties& mass, const Vec3& size, const Vec3& centre) {
  EXPECT_TRUE(mass.solid);
  EXPECT_NEAR(mass.volume, size.prod(), 1e-9);
  EXPECT_TRUE(mass.p_MBo.isApprox(centre, 1e-9)) << mass.p_MBo.transpose();
  const Vec3 squares = size.cwiseProduct(size);
  const Vec3 diagonal = (Vec3::Constant(squares.sum()) - squares) / 12;
  EXPECT_TRUE(mass.unit_inertia.isApprox(Mat3(diagonal.asDiagonal()), 1e-9)) << mass.unit_inertia;
}

TEST(UnionMass, SharedMaterialCountsOnce) {
  // two cubes of side 2 that share 1 x 2 x 2 make a bar of 3 x 2 x 2
  const TriangleMesh cube = BoxMesh(Vec3::Constant(2));
  ExpectCuboid(ComputeUnionMass(Both(cube, MovedBy(cube, Vec3(1, 0, 0)))), Vec3(3, 2, 2),
               Vec3(1.5, 1, 1));
  // three of them in a row, the middle one within the others
  ExpectCuboid(ComputeUnionMass(
                   Both(Both(cube, MovedBy(cube, Vec3(2, 0, 0))), MovedBy(cube, Vec3(1, 0, 0)))),
               Vec3(4, 2, 2), Vec3(2, 1, 1));
  EXPECT_NEAR(ComputeMassProperties(Both(cube, MovedBy(cube, Vec3(1, 0, 0)))).volume, 16, 1e-9);
}

// Numbers of single precision, and diagonals that cross: some pieces of faces have no area.
TEST(UnionMass, BarsOfSinglePrecisionThatShareFacesCountOnce) {
  TriangleMesh bar;
  for (int corner = 0; corner < 8; ++corner) {
    bar.vertices.emplace_back(corner & 1, corner >> 1 & 1, corner >> 2);
  }
  bar.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  const auto at = [&](double from, double to) {
    TriangleMesh placed = bar;
    for (Vec3& v : placed.vertices) {
      v = Vec3(v.x() < 0.5 ? from : to, 0.02 * v.y() - 0.01, 0.02 * v.z() - 0.01);
      for (double& x : v) x = double{static_cast<float>(x)};
    }
    return placed;
  };
  for (const double step : {0.04, 0.01, 0.02, 0.03, 0.05}) {
    const UnionMass mass = ComputeUnionMass(Both(at(-0.03, 0.03), at(step - 0.03, step + 0.03)));
    EXPECT_NEAR(mass.volume, (0.06 + step) * 4e-4, 1e-11) << step;
  }
}

TEST(UnionMass, SolidWithinAnotherAddsNothing) {
  const TriangleMesh block = BoxMesh(Vec3(4, 5, 6));
  ExpectCuboid(ComputeUnionMass(Both(block, MovedBy(BoxMesh(Vec3::Constant(1)), Vec3(1, 1, 1)))),
               Vec3(4, 5, 6), Vec3(2, 2.5, 3));
  // the same corner of both, which makes one body of them
  TriangleMesh welded = Both(block, BoxMesh(Vec3::Constant(1)));
  for (TriangleMesh::Triangle& t : welded.triangles) {
    for (std::uint32_t& i : t) i = i == 8 ? 0 : i;
  }
  ExpectCuboid(ComputeUnionMass(welded), Vec3(4, 5, 6), Vec3(2, 2.5, 3));
}

TEST(UnionMass, CavityStaysEmpty) {
  const TriangleMesh cavity =
      MovedBy(testing::InsideOut(BoxMesh(Vec3::Constant(1))), Vec3(1, 1, 1));
  const MassProperties mass = ComputeUnionMass(Both(BoxMesh(Vec3::Constant(3)), cavity));
  EXPECT_NEAR(mass.volume, 26, 1e-9);
  EXPECT_TRUE(mass.p_MBo.isApprox(Vec3::Constant(1.5), 1e-9));
}

TEST(UnionMass, SolidsThatTouchOrStandApartAreAsBefore) {
  const TriangleMesh cube = BoxMesh(Vec3::Constant(1));
  for (const Vec3& offset : {Vec3(1, 0, 0), Vec3(0.5, 1, 0), Vec3(3, 3, 3)}) {
    const TriangleMesh both = Both(cube, MovedBy(cube, offset));
    const MassProperties mass = ComputeUnionMass(both);
    const MassProperties plain = ComputeMassProperties(both);
    EXPECT_EQ(mass.volume, plain.volume);
    EXPECT_EQ(mass.p_MBo, plain.p_MBo);
    EXPECT_EQ(mass.unit_inertia, plain.unit_inertia);
  }
}

// Two unit balls whose centres are 1 apart share a lens of 5 pi / 12: the union has 27 pi / 12.
TEST(UnionMass, BallsThatCrossHaveTheVolumeOfTheirUnion) {
  const TriangleMesh ball = SphereMesh(1, 4);
  const MassProperties mass = ComputeUnionMass(Both(ball, MovedBy(ball, Vec3(1, 0, 0))));
  EXPECT_NEAR(mass.volume / (27 * std::numbers::pi / 12), 1, 0.005);
  EXPECT_TRUE(mass.p_MBo.isApprox(Vec3(0.5, 0, 0), 1e-3));
}

// ---- Solids that are turned inside out ----

TEST(UnionMass, ShellThatIsWoundInsideOutCountsAsItsNeighbours) {
  const TriangleMesh block = BoxMesh(Vec3(4, 5, 6));
  const TriangleMesh cube = BoxMesh(Vec3::Constant(2));
  const TriangleMesh right = MovedBy(cube, Vec3(9, 0, 0));
  const MassProperties mass = ComputeUnionMass(Both(block, testing::InsideOut(right)));
  EXPECT_TRUE(mass.solid);
  EXPECT_NEAR(mass.volume, 120 + 8, 1e-9);
  const Vec3 centre = (120 * Vec3(2, 2.5, 3) + 8 * Vec3(10, 1, 1)) / 128;
  EXPECT_TRUE(mass.p_MBo.isApprox(centre, 1e-9)) << mass.p_MBo.transpose();
  // the larger one is the one that is wrong
  EXPECT_NEAR(ComputeUnionMass(Both(testing::InsideOut(block), right)).volume, -128, 1e-9);
  // within the box round a ball, but not within the ball
  const TriangleMesh ball = SphereMesh(1, 3);
  const TriangleMesh beside =
      testing::InsideOut(MovedBy(BoxMesh(Vec3::Constant(0.1)), Vec3::Constant(0.85)));
  EXPECT_NEAR(ComputeUnionMass(Both(ball, beside)).volume,
              ComputeMassProperties(ball).volume + 1e-3, 1e-9);
}

TEST(UnionMass, CavityOfAMeshThatFacesInwardsStaysEmpty) {
  const TriangleMesh cavity =
      MovedBy(testing::InsideOut(BoxMesh(Vec3::Constant(1))), Vec3(1, 1, 1));
  const TriangleMesh shell = Both(BoxMesh(Vec3::Constant(3)), cavity);
  EXPECT_NEAR(ComputeUnionMass(testing::InsideOut(shell)).volume, -26, 1e-9);
}

// ---- Solids that lie exactly on themselves ----

TEST(UnionMass, SolidOfTheSameCornersTwiceCountsOnce) {
  const TriangleMesh block = BoxMesh(Vec3(4, 5, 6));
  TriangleMesh twice = block;
  twice.triangles.insert(twice.triangles.end(), block.triangles.begin(), block.triangles.end());
  ExpectCuboid(ComputeUnionMass(twice), Vec3(4, 5, 6), Vec3(2, 2.5, 3));
  twice.triangles.insert(twice.triangles.end(), block.triangles.begin(), block.triangles.end());
  ExpectCuboid(ComputeUnionMass(twice), Vec3(4, 5, 6), Vec3(2, 2.5, 3));
  ExpectCuboid(ComputeUnionMass(Both(block, block)), Vec3(4, 5, 6), Vec3(2, 2.5, 3));
}

// ---- The bound on its work ----

/// Thin boxes that all cross one another: each face of one is cut by all of the others.
TriangleMesh CrossingPlates(int plates) {
  TriangleMesh all;
  for (int i = 0; i < plates; ++i) {
    TriangleMesh plate = MovedBy(BoxMesh(Vec3(1, 1, 1e-3)), Vec3(-0.5, -0.5, 0));
    const double angle = 0.01 + 3.1 * i / plates;
    const Mat3 R = (Eigen::AngleAxisd(angle, Vec3(1, 0.3 * (i % 7), 0.2 * (i % 5)).normalized()))
                       .toRotationMatrix();
    for (Vec3& vertex : plate.vertices) vertex = R * vertex + 1e-3 * i * Vec3(1, 2, 3);
    Append(all, plate);
  }
  return all;
}

TEST(UnionMass, MeshOfTooMuchWorkCountsSharedMaterialTwiceAndSaysSo) {
  const TriangleMesh plates = CrossingPlates(300);
  const UnionMass mass = ComputeUnionMass(plates, 1'000'000);
  EXPECT_TRUE(mass.counts_twice);
  EXPECT_NEAR(mass.volume, 300 * 1e-3, 1e-9);
  const UnionMass few = ComputeUnionMass(CrossingPlates(4));
  EXPECT_FALSE(few.counts_twice);
  EXPECT_LT(few.volume, 4e-3 * (1 - 1e-4));
  EXPECT_GT(few.volume, 3e-3);
}

TEST(UnionMass, SolidsThatStandApartAreNoWork) {
  TriangleMesh all;
  for (int i = 0; i < 4000; ++i) {
    Append(all, MovedBy(BoxMesh(Vec3(100, 1, 1)), Vec3(0, 2 * (i % 63), 2 * (i / 63))));
  }
  const UnionMass mass = ComputeUnionMass(all, 1'000'000);
  EXPECT_FALSE(mass.counts_twice);
  EXPECT_NEAR(mass.volume, 400'000, 1e-3);
}

TEST(UnionMass, BudgetDecidesWhateverTheNumberOfThreads) {
  const TriangleMesh plates = CrossingPlates(6);
  std::uint64_t enough = 1000;
  while (ComputeUnionMass(plates, enough).counts_twice) enough += enough / 8;
  for (int run = 0; run < 20; ++run) {
    EXPECT_FALSE(ComputeUnionMass(plates, enough).counts_twice);
    EXPECT_TRUE(ComputeUnionMass(plates, enough * 7 / 8).counts_twice);
  }
}

TEST(UnionMass, MeshThatFacesInwardsHasANegativeVolume) {
  const TriangleMesh cube = BoxMesh(Vec3::Constant(2));
  const MassProperties mass =
      ComputeUnionMass(testing::InsideOut(Both(cube, MovedBy(cube, Vec3(1, 0, 0)))));
  EXPECT_NEAR(mass.volume, -12, 1e-9);
  EXPECT_TRUE(mass.p_MBo.isApprox(Vec3(1.5, 1, 1), 1e-9));
}

}  // namespace
}  // namespace tandem
