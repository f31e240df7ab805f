// Tests fields of real meshes that others made. TANDEM_MODELS names their folder, and without it
// these tests are skipped. distance_field_test.cpp makes the same claims on meshes of this tree.
#include <cstdlib>
#include <filesystem>
#include <random>

#include <gtest/gtest.h>

#include "engine/field/build/field_builder.h"
#include "engine/geometry/import/mesh_file.h"
#include "tests/engine/field/brute_distance.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

/// Meshes of one body each, closed but for cracks without width.
constexpr auto kSoundMeshes = {"factory/factory_bolt_m16_tight.obj",
                               "factory/factory_nut_m16_tight_subdiv_3x.obj",
                               "factory/factory_bolt_m16_loose.obj",
                               "factory/factory_round_hole_8mm_subdiv_3x.obj",
                               "factory/factory_round_peg_8mm_tight.obj",
                               "factory/factory_rectangular_hole_8mm_subdiv_3x.obj",
                               "factory/factory_rectangular_peg_8mm_loose_subdiv_3x.obj",
                               "so101/Wrist_Roll_SO101.stl",
                               "classic/spot_triangulated.obj"};

TEST(ThirdPartyFields, AreWithinTheirErrorBounds) {
  const char* folder =
      std::getenv("TANDEM_MODELS");  // NOLINT(concurrency-mt-unsafe): nobody sets it
  if (folder == nullptr) GTEST_SKIP() << "TANDEM_MODELS does not name the folder of the models";
  for (const char* name : kSoundMeshes) {
    const Result<TriangleMesh> mesh = ImportMesh(fs::path(folder) / name, {.seconds_limit = 60});
    ASSERT_TRUE(mesh) << mesh.error().what;
    const double voxel_size = BoundsOf(*mesh).size().maxCoeff() / 120;
    const Result<DistanceField> field = BuildField(*mesh, {.voxel_size = voxel_size});
    ASSERT_TRUE(field) << name << ": " << field.error().what;
    const testing::BruteDistance exact(*mesh);
    std::mt19937_64 random(1);
    for (int i = 0; i < 1500; ++i) {
      const Vec3 p_M = exact.PlaceNear((i % 8 == 0 ? 20 : 0.6) * voxel_size, random);
      const double distance = exact.Signed(p_M) / voxel_size;
      const FieldReading reading = field->At((p_M - field->p_WVo()) / voxel_size);
      if (std::abs(distance) < field->band()) {
        ASSERT_TRUE(reading.near) << name;
        ASSERT_NEAR(reading.value, distance, field->error_bound())
            << name << " at " << p_M.transpose();
      } else if (!reading.near) {
        ASSERT_LE(std::abs(reading.value), std::abs(distance) + 1e-6) << name;
      }
    }
  }
}

}  // namespace
}  // namespace tandem
