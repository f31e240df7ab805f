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

TEST(UnionMass, MeshThatFacesInwardsHasANegativeVolume) {
  const TriangleMesh cube = BoxMesh(Vec3::Constant(2));
  const MassProperties mass =
      ComputeUnionMass(testing::InsideOut(Both(cube, MovedBy(cube, Vec3(1, 0, 0)))));
  EXPECT_NEAR(mass.volume, -12, 1e-9);
  EXPECT_TRUE(mass.p_MBo.isApprox(Vec3(1.5, 1, 1), 1e-9));
}

}  // namespace
}  // namespace tandem
