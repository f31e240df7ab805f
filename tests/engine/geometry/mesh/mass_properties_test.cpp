#include "engine/geometry/mesh/mass_properties.h"

#include <gtest/gtest.h>

#include "engine/geometry/mesh/mesh_diagnosis.h"
#include "tests/engine/geometry/shapes.h"

namespace tandem {
namespace {

using testing::BoxMesh;
using testing::InsideOut;
using testing::MovedBy;
using testing::SphereMesh;

/// Returns the inertia of a box about its centre, for unit mass.
Mat3 BoxInertia(const Vec3& size) {
  const Vec3 squares = size.cwiseProduct(size);
  return Mat3((Vec3::Constant(squares.sum()) - squares).asDiagonal()) / 12;
}

/// Returns the inertia about a point at `r` from the centre of mass, less that about the centre.
Mat3 Steiner(const Vec3& r) {
  return r.squaredNorm() * Mat3::Identity() - r * r.transpose();
}

void ExpectNear(const Mat3& value, const Mat3& expected, double relative) {
  EXPECT_LE((value - expected).norm(), relative * expected.norm()) << value << "\nis not\n"
                                                                   << expected;
}

TEST(MassProperties, OfABoxMatchTheTextbook) {
  const Vec3 size(0.1, 0.02, 0.3);
  const MassProperties box = ComputeMassProperties(BoxMesh(size));
  EXPECT_TRUE(box.solid);
  EXPECT_NEAR(box.volume, 6e-4, 1e-15);
  EXPECT_LE((box.p_MBo - 0.5 * size).norm(), 1e-15);
  ExpectNear(box.unit_inertia, BoxInertia(size), 1e-12);
}

// The oracle integrates over the tetrahedra from the centre to each triangle by a four-point rule,
// which is exact for second moments.
TEST(MassProperties, OfASubdividedSphereMatchThePolyhedron) {
  const TriangleMesh sphere = SphereMesh(0.01, 3);
  double volume = 0;
  Mat3 second = Mat3::Zero();
  for (std::size_t t = 0; t < sphere.triangles.size(); ++t) {
    const Vec3& a = sphere.corner(t, 0);
    const Vec3& b = sphere.corner(t, 1);
    const Vec3& c = sphere.corner(t, 2);
    const Vec3 area = 0.5 * (b - a).cross(c - a);
    const double part = area.norm() * area.normalized().dot(a) / 3;
    volume += part;
    const std::array<Vec3, 4> corners{Vec3::Zero(), a, b, c};
    const Vec3 sum = a + b + c;
    for (const Vec3& corner : corners) {
      const Vec3 x = 0.1381966011250105 * (sum - corner) + 0.5854101966249685 * corner;
      second += 0.25 * part * x * x.transpose();
    }
  }
  const MassProperties properties = ComputeMassProperties(sphere);
  EXPECT_TRUE(properties.solid);
  EXPECT_NEAR(properties.volume / volume, 1, 1e-12);
  EXPECT_LE(properties.p_MBo.norm(), 1e-14);
  ExpectNear(properties.unit_inertia, (second.trace() * Mat3::Identity() - second) / volume, 1e-12);
}

// The polyhedron's error falls by four with each split, so the limit can be told from two of them.
TEST(MassProperties, OfRefinedSpheresConvergeToTheBall) {
  const MassProperties coarse = ComputeMassProperties(SphereMesh(2, 4));
  const MassProperties fine = ComputeMassProperties(SphereMesh(2, 5));
  const double volume = (4 * fine.volume - coarse.volume) / 3;
  const Mat3 inertia = (4 * fine.unit_inertia - coarse.unit_inertia) / 3;
  EXPECT_NEAR(volume / (32 * std::numbers::pi / 3), 1, 1e-5);
  ExpectNear(inertia, 1.6 * Mat3::Identity(), 1e-5);
}

// The tetrahedron (0, e1, e2, e3) has E[x] = 1/4, E[xx] = 1/10, E[xy] = 1/20.
TEST(MassProperties, ArePreciseFarFromTheOrigin) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const Vec3 far(65536, -131072, 1048576);  // the corners stay exact there
  const MassProperties properties = ComputeMassProperties(MovedBy(mesh, far));
  EXPECT_TRUE(properties.solid);
  EXPECT_NEAR(properties.volume, 1.0 / 6, 1e-12);
  EXPECT_LE((properties.p_MBo - far - Vec3::Constant(0.25)).norm(), 1e-9);
  ExpectNear(properties.unit_inertia,
             Mat3(Vec3::Constant(5.0 / 80).asDiagonal()) + Mat3::Constant(1.0 / 80), 1e-9);
}

TEST(MassProperties, TransformWithTheMesh) {
  const Vec3 size(1, 2, 5);
  const Pose X_WM{Quat(0.3, -0.5, 0.7, 0.1).normalized(), Vec3(-4, 11, 6)};
  const MassProperties moved = ComputeMassProperties(Transformed(BoxMesh(size), X_WM));
  const Mat3 R_WM = X_WM.q.toRotationMatrix();
  EXPECT_NEAR(moved.volume, 10, 1e-10);
  EXPECT_LE((moved.p_MBo - X_WM * Vec3(0.5 * size)).norm(), 1e-11);
  ExpectNear(moved.unit_inertia, R_WM * BoxInertia(size) * R_WM.transpose(), 1e-11);
}

TEST(MassProperties, OfTwoDisjointBodiesFollowTheParallelAxisTheorem) {
  const Vec3 size_a(1, 2, 3);
  const Vec3 size_b(2, 2, 0.5);
  const Vec3 at_b(7, -3, 1);
  TriangleMesh both = BoxMesh(size_a);
  Append(both, MovedBy(BoxMesh(size_b), at_b));
  const MassProperties properties = ComputeMassProperties(both);

  const double share_a = 6.0 / 8.0;  // volumes are 6 and 2
  const Vec3 centre_a = 0.5 * size_a;
  const Vec3 centre_b = at_b + 0.5 * size_b;
  const Vec3 centre = share_a * centre_a + (1 - share_a) * centre_b;
  EXPECT_TRUE(properties.solid);
  EXPECT_NEAR(properties.volume, 8, 1e-12);
  EXPECT_LE((properties.p_MBo - centre).norm(), 1e-12);
  ExpectNear(properties.unit_inertia,
             share_a * (BoxInertia(size_a) + Steiner(centre_a - centre)) +
                 (1 - share_a) * (BoxInertia(size_b) + Steiner(centre_b - centre)),
             1e-12);
}

TEST(MassProperties, OfAnInvertedBoxDifferOnlyInTheSignOfVolume) {
  const Vec3 size(1, 2, 3);
  const MassProperties box = ComputeMassProperties(InsideOut(BoxMesh(size)));
  EXPECT_TRUE(box.solid);
  EXPECT_NEAR(box.volume, -6, 1e-12);
  EXPECT_LE((box.p_MBo - 0.5 * size).norm(), 1e-12);
  ExpectNear(box.unit_inertia, BoxInertia(size), 1e-12);
}

// A cube of 4 with a cube of 2 missing: 64 - 8 of mass.
TEST(MassProperties, ExcludeCavities) {
  TriangleMesh hollow = BoxMesh(Vec3::Constant(4));
  Append(hollow, InsideOut(MovedBy(BoxMesh(Vec3::Constant(2)), Vec3::Constant(1))));
  const MassProperties properties = ComputeMassProperties(hollow);
  EXPECT_TRUE(properties.solid);
  EXPECT_NEAR(properties.volume, 56, 1e-11);
  ExpectNear(properties.unit_inertia,
             (64 * BoxInertia(Vec3::Constant(4)) - 8 * BoxInertia(Vec3::Constant(2))) / 56, 1e-12);
}

TEST(MassProperties, OfASheetLieOnItsSurface) {
  TriangleMesh sheet;
  sheet.vertices = {{0, 0, 1}, {2, 0, 1}, {2, 1, 1}, {0, 1, 1}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const MassProperties properties = ComputeMassProperties(sheet);
  EXPECT_FALSE(properties.solid);
  EXPECT_NEAR(properties.volume, 0, 1e-15);
  EXPECT_LE((properties.p_MBo - Vec3(1, 0.5, 1)).norm(), 1e-15);
  ExpectNear(properties.unit_inertia, BoxInertia(Vec3(2, 1, 0)), 1e-12);

  // the same sheet with a back is closed, and still encloses nothing
  Append(sheet, InsideOut(sheet));
  EXPECT_FALSE(ComputeMassProperties(sheet).solid);
}

// Two triangles so small that their corners are one point to the reference between them.
TEST(MassProperties, HandleTinyDistantTriangles) {
  TriangleMesh specks;
  specks.vertices = {{0, 0, 0}, {1e-12, 0, 0}, {0, 1e-12, 0}};
  specks.triangles = {{0, 1, 2}};
  Append(specks, specks);
  specks.vertices[3] = {1e6, 0, 0};
  specks.vertices[4] = {1e6, 0, 0};
  specks.vertices[5] = {1e6, 0, 0};
  const MassProperties properties = ComputeMassProperties(specks);
  EXPECT_FALSE(properties.solid);
  EXPECT_LE(properties.p_MBo.norm(), 1e-9);
}

// Five unit squares: the floor at height 0, four walls at height 1/2 in the mean.
TEST(MassProperties, OfABoxWithoutLidLieOnItsSurface) {
  TriangleMesh box = BoxMesh(Vec3::Constant(1));
  box.triangles.erase(box.triangles.begin() + 2, box.triangles.begin() + 4);
  const MassProperties properties = ComputeMassProperties(box);
  EXPECT_FALSE(properties.solid);
  EXPECT_LE((properties.p_MBo - Vec3(0.5, 0.5, 0.4)).norm(), 1e-12);
}

TEST(MassProperties, OfATubeOpenAtBothEndsLieOnItsSurface) {
  TriangleMesh tube = BoxMesh(Vec3::Constant(1));
  tube.triangles.erase(tube.triangles.begin(), tube.triangles.begin() + 4);
  const MassProperties properties = ComputeMassProperties(tube);
  EXPECT_FALSE(properties.solid) << "its open ends cancel, but both are open";
  EXPECT_LE((properties.p_MBo - Vec3::Constant(0.5)).norm(), 1e-12);
}

TEST(MassProperties, OfInconsistentlyOrientedBodiesLieOnTheSurface) {
  TriangleMesh mesh = BoxMesh(Vec3::Constant(1));
  Append(mesh, InsideOut(MovedBy(BoxMesh(Vec3::Constant(0.5)), Vec3(3, 0, 0))));
  EXPECT_FALSE(ComputeMassProperties(mesh).solid);
}

// One side of an edge is split in the middle, the other is not: three open edges, and no hole.
TEST(MassProperties, TolerateTJunctionCracks) {
  const Vec3 size(1, 2, 3);
  TriangleMesh box = BoxMesh(size);
  box.vertices.emplace_back(0.5 * size.x(), 0, 0);
  box.triangles[1] = {0, 3, 8};
  box.triangles.push_back({8, 3, 1});
  ASSERT_EQ(Diagnose(box).open_edges, 3U);
  const MassProperties properties = ComputeMassProperties(box);
  EXPECT_TRUE(properties.solid);
  EXPECT_NEAR(properties.volume, 6, 1e-12);
  ExpectNear(properties.unit_inertia, BoxInertia(size), 1e-12);
}

// The lid has vertices of its own, off by less than a float can tell at this size.
TEST(MassProperties, TolerateAnUnweldedSeam) {
  TriangleMesh box = BoxMesh(Vec3::Constant(1));
  for (std::uint32_t i = 4; i < 8; ++i) {
    box.vertices.emplace_back(box.vertices[i] + Vec3::Constant(1e-7));
  }
  for (const std::size_t t : {2U, 3U}) {
    for (std::uint32_t& i : box.triangles[t]) i += 4;
  }
  ASSERT_EQ(Diagnose(box).open_edges, 8U);
  const MassProperties properties = ComputeMassProperties(box);
  EXPECT_TRUE(properties.solid);
  EXPECT_NEAR(properties.volume, 1, 1e-6);
}

}  // namespace
}  // namespace tandem
