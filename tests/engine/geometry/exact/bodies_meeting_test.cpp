#include "engine/geometry/exact/bodies_meeting.h"

#include <gtest/gtest.h>

#include "engine/geometry/exact/exact_surface.h"
#include "tests/engine/geometry/shapes.h"

namespace tandem {
namespace {

using testing::BoxMesh;
using testing::MovedBy;

/// Returns unit boxes along x, two apart.
TriangleMesh Row(int count) {
  TriangleMesh row;
  for (int i = 0; i < count; ++i) {
    Append(row, MovedBy(BoxMesh(Vec3::Constant(1)), Vec3(2.0 * i, 0, 0)));
  }
  return row;
}

Bounds Between(const Vec3& min, const Vec3& max) {
  Bounds box;
  box.Add(min);
  box.Add(max);
  return box;
}

TEST(BodiesMeeting, KeepsWholeBodiesThatTheBoxMeets) {
  const TriangleMesh row = Row(5);
  const Bounds box = Between({2.5, 0.2, 0.2}, {4.1, 0.4, 0.4});
  const TriangleMesh met = BodiesMeeting(row, box);
  EXPECT_EQ(met.triangles.size(), 24U);
  EXPECT_EQ(met.vertices.size(), 16U);
  EXPECT_EQ(BoundsOf(met).min.x(), 2);
  EXPECT_EQ(BoundsOf(met).max.x(), 5);
  const ExactSurface all(row);
  const ExactSurface some(met);
  for (double x = box.min.x(); x <= box.max.x(); x += 0.05) {
    const Vec3 p(x, 0.3, 0.3);
    EXPECT_EQ(all.Depth(p), some.Depth(p)) << x;
  }
  EXPECT_TRUE(BodiesMeeting(row, Between({0, 5, 0}, {9, 6, 1})).triangles.empty());
}

TEST(BodiesMeeting, KeepsAllOfAnOpenMesh) {
  TriangleMesh row = Row(3);
  row.triangles.pop_back();
  EXPECT_EQ(BodiesMeeting(row, Between(Vec3::Zero(), Vec3::Ones())).triangles.size(), 35U);
}

}  // namespace
}  // namespace tandem
