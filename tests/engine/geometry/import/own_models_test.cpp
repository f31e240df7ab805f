// Tests what is known of the meshes that this tree makes itself, read from their files. It is the
// counterpart of third_party_models_test.cpp that runs everywhere.
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/geometry/import/mesh_file.h"
#include "engine/geometry/mesh/mass_properties.h"
#include "engine/geometry/mesh/mesh_diagnosis.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

const fs::path kOwnModels = TANDEM_SCENES;

TEST(OwnModels, LoadAndHaveAMass) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kOwnModels)) {
    if (entry.path().extension() == ".stl") files.push_back(entry);
  }
  EXPECT_GE(files.size(), 16U);
  for (const fs::path& file : files) {
    const Result<TriangleMesh> mesh = ImportMesh(file, {.seconds_limit = 60});
    ASSERT_TRUE(mesh) << mesh.error().what;
    const MassProperties properties = ComputeMassProperties(*mesh);
    EXPECT_TRUE(properties.solid) << file;
    EXPECT_GT(properties.volume, 0) << file;
    EXPECT_TRUE(properties.p_MBo.allFinite()) << file;
    EXPECT_GT(properties.unit_inertia.determinant(), 0) << file;
  }
}

TEST(OwnModels, MatchTheirDimensions) {
  struct Fact {
    const char* file;
    std::size_t triangles;
    double volume;  // mm^3
  };
  // a prism of 8 corners in the slot's case: 94 by 62 mm round a bay of 86 by 46, 40 long
  const std::vector<Fact> facts{{"press_blocks_left.stl", 12, 60.0 * 60 * 60},
                                {"press_blocks_right.stl", 12, 60.0 * 60 * 60},
                                {"stability/cube.stl", 12, 40.0 * 40 * 40},
                                {"stability/cube_in_slot.stl", 12, 40.0 * 40 * 40},
                                {"stability/wall.stl", 12, 8.0 * 120 * 120},
                                {"stability/slot.stl", 28, (94.0 * 62 - 86.0 * 46) * 40}};
  for (const Fact& fact : facts) {
    const Result<TriangleMesh> mesh = ImportMesh(kOwnModels / fact.file);
    ASSERT_TRUE(mesh) << mesh.error().what;
    EXPECT_EQ(mesh->triangles.size(), fact.triangles) << fact.file;
    EXPECT_EQ(Describe(Diagnose(*mesh)), "closed, 1 body") << fact.file;
    EXPECT_NEAR(ComputeMassProperties(*mesh).volume / fact.volume, 1, 1e-6) << fact.file;
  }
}

// An octahedron cut three times has 8 x 4^3 triangles, and its corners on the ball of 12 mm: it is
// within the ball, and by no more than its flat triangles are.
TEST(OwnModels, BallsFacetsLieWithinTheBall) {
  const Result<TriangleMesh> ball = ImportMesh(kOwnModels / "stability" / "ball.stl");
  ASSERT_TRUE(ball) << ball.error().what;
  EXPECT_EQ(ball->triangles.size(), 512U);
  const double share = ComputeMassProperties(*ball).volume / (4.0 / 3.0 * M_PI * 12 * 12 * 12);
  EXPECT_LT(share, 1.0);
  EXPECT_GT(share, 0.95);
  for (const Vec3& corner : ball->vertices) EXPECT_NEAR(corner.norm(), 12.0, 1e-5);
}

}  // namespace
}  // namespace tandem
