#include "engine/voxel/build/inside_winding.h"

#include <cstdlib>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/voxel/build/voxelize.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

/// Returns long narrow triangles through a cube of one metre, each a body of its own.
TriangleMesh Slivers(std::size_t count) {
  std::mt19937 random(40);
  std::uniform_real_distribution<double> place(0, 1);
  const auto draw = [&] {
    const double x = place(random);
    const double y = place(random);
    return Vec3(x, y, place(random));
  };
  TriangleMesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 a = draw();
    const Vec3 b = draw();
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, a + 0.05 * draw()});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

std::optional<Error> CostFault(const TriangleMesh& mesh, double voxel_size) {
  return WindingCostFault(mesh, FindFacing(mesh, MeshSides(mesh)), voxel_size);
}

// A file of 100 kB: at this size a processor took minutes.
TEST(InsideWinding, SmallMeshThatWouldCostMinutesIsRefusedInOneLine) {
  const TriangleMesh mesh = Slivers(2048);
  const Result<Voxmap> made = Voxelize(mesh, {.voxel_size = AutoVoxelSize(mesh)});
  ASSERT_FALSE(made);
  const std::string& what = made.error().what;
  EXPECT_THAT(what, HasSubstr("2048 triangles are of open bodies"));
  EXPECT_EQ(what.find('\n'), std::string::npos);
  // the size that it names is coarser, does, and is not far from one that does not
  const std::string before = "or use voxels of ";
  ASSERT_THAT(what, HasSubstr(before));
  const double named = std::strtod(&what[what.find(before) + before.size()], nullptr);
  EXPECT_GT(named, AutoVoxelSize(mesh));
  EXPECT_FALSE(CostFault(mesh, named));
  EXPECT_TRUE(CostFault(mesh, 0.8 * named));
}

TEST(InsideWinding, OpenMeshesOfUsualShapeAreVoxelized) {
  // half a ball, and a ball with a hole in every eighth triangle
  TriangleMesh ball = testing::Sphere(0.5, 4);
  TriangleMesh bowl = ball;
  std::erase_if(bowl.triangles, [&](const TriangleMesh::Triangle& t) {
    return ball.vertices[t[0]].z() > 0;
  });
  TriangleMesh holed{ball.vertices, {}};
  for (std::size_t t = 0; t < ball.triangles.size(); ++t) {
    if (t % 8 != 0) holed.triangles.push_back(ball.triangles[t]);
  }
  for (const TriangleMesh* mesh : {&bowl, &holed}) {
    EXPECT_FALSE(CostFault(*mesh, AutoVoxelSize(*mesh)));
    EXPECT_FALSE(CostFault(*mesh, 0.3 * AutoVoxelSize(*mesh)));
  }
  EXPECT_FALSE(CostFault(testing::Sheet(1), 0.001));
}

TEST(InsideWinding, ClosedBodiesCostNothingWhateverTheirSize) {
  const TriangleMesh ball = testing::Sphere(0.5, 3);
  EXPECT_FALSE(CostFault(ball, 1e-9));
  // beside open ones, only these count
  TriangleMesh both = ball;
  Append(both, Slivers(2048));
  const std::optional<Error> fault = CostFault(both, AutoVoxelSize(both));
  ASSERT_TRUE(fault);
  EXPECT_THAT(fault->what, HasSubstr("2048 triangles are of open bodies"));
}

}  // namespace
}  // namespace tandem
