// Tests what is known of real meshes that others made. They are not part of the tree: TANDEM_MODELS
// names their folder, and without it these tests are skipped. The same claims on meshes of this
// tree are in own_models_test.cpp (mass, bodies, volumes) and mesh_file_test.cpp (damaged files,
// seams, axes).
#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <sys/wait.h>

#include "engine/geometry/import/mesh_file.h"
#include "engine/geometry/mesh/mass_properties.h"
#include "engine/geometry/mesh/mesh_diagnosis.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

/// Returns whether a file is a mesh and no other file's buffer or material.
bool IsMeshFile(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto known = {".3mf", ".dae", ".glb", ".gltf", ".obj", ".off", ".ply", ".stl"};
  return std::find(known.begin(), known.end(), extension) != known.end();
}

class ThirdPartyModels : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder =
        std::getenv("TANDEM_MODELS");  // NOLINT(concurrency-mt-unsafe): nobody sets it
    if (folder == nullptr) GTEST_SKIP() << "TANDEM_MODELS does not name the folder of the models";
    folder_ = folder;
    ASSERT_TRUE(fs::is_directory(folder_)) << folder_;
  }

  std::vector<fs::path> Files(bool bad) const {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_)) {
      const bool in_bad = entry.path().lexically_relative(folder_).begin()->string() == "bad";
      if (entry.is_regular_file() && IsMeshFile(entry) && in_bad == bad) files.push_back(entry);
    }
    return files;
  }

  template <typename Check>
  static void ForEach(const std::vector<fs::path>& files, Check check) {
    std::atomic<std::size_t> next{0};
    std::vector<std::thread> threads;
    threads.reserve(4);
    for (int i = 0; i < 4; ++i) {
      threads.emplace_back([&] {
        for (std::size_t n = next++; n < files.size(); n = next++) check(files[n]);
      });
    }
    for (std::thread& thread : threads) thread.join();
  }

  fs::path folder_;
};

TEST_F(ThirdPartyModels, ValidModelsLoadAndHaveAMass) {
  const std::vector<fs::path> files = Files(false);
  EXPECT_GE(files.size(), 70U);
  ForEach(files, [](const fs::path& file) {
    const Result<TriangleMesh> mesh = ImportMesh(file, {.seconds_limit = 60});
    ASSERT_TRUE(mesh) << mesh.error().what;
    EXPECT_FALSE(mesh->triangles.empty()) << file;
    const MassProperties properties = ComputeMassProperties(*mesh);
    // the one file that is open on purpose, and not just cracked
    EXPECT_EQ(properties.solid, file.filename() != "fully_featured.glb") << file;
    EXPECT_TRUE(properties.p_MBo.allFinite()) << file;
    EXPECT_GT(properties.unit_inertia.determinant(), 0) << file;
  });
}

TEST_F(ThirdPartyModels, InvalidModelsGiveAMeshOrOneErrorLine) {
  const std::vector<fs::path> files = Files(true);
  EXPECT_GE(files.size(), 30U);
  ForEach(files, [](const fs::path& file) {
    const Result<TriangleMesh> mesh = ImportMesh(file);
    if (!mesh) {
      EXPECT_THAT(mesh.error().what, ::testing::Not(::testing::HasSubstr("\n")));
      EXPECT_THAT(mesh.error().what, ::testing::HasSubstr(file.filename()));
      return;
    }
    EXPECT_FALSE(mesh->triangles.empty()) << file;
    EXPECT_FALSE(Describe(Diagnose(*mesh)).empty()) << file;
    EXPECT_TRUE(ComputeMassProperties(*mesh).unit_inertia.allFinite()) << file;
  });
  EXPECT_TRUE(waitpid(-1, nullptr, WNOHANG) == -1 && errno == ECHILD) << "a reader is left over";
}

TEST_F(ThirdPartyModels, HaveTheirKnownBodiesAndCracks) {
  struct Fact {
    const char* file;
    std::size_t triangles;
    const char* diagnosis;
  };
  const std::vector<Fact> facts{
      {"factory/factory_bolt_m16_loose.obj", 25668, "closed, 1 body"},
      {"factory/factory_nut_m16_loose_subdiv_3x.obj", 15080,
       "108 open edges, 32 flat triangles; 1 body"},
      {"factory/factory_nut_m16_tight_subdiv_3x.obj", 15078,
       "108 open edges, 16 flat triangles; 1 body"},
      {"factory/factory_round_hole_16mm_subdiv_3x.obj", 900, "36 open edges; 1 body"},
      {"factory/factory_gear_base_loose_space_5e-4_subdiv_4x.obj", 9630,
       "68 open edges, 48 flat triangles; 4 bodies"},
      {"factory/factory_gear_small_space_5e-4.obj", 20532, "closed, 12 flat triangles; 1 body"},
      {"rigid-ipc/092-piston/piston.stl", 2140, "closed, 4 bodies"},
      {"rigid-ipc/140-punching-press/p1.off", 736, "closed, 2 bodies"},
      {"so101/Wrist_Roll_Pitch_SO101.stl", 17036, "closed, 1 body"},
      {"so101/Moving_Jaw_SO101.stl", 11260, "closed, 2 bodies"},
      {"furniture-bench/square_table_top.obj", 24128, "closed, 9 bodies"},
      {"3mf/cube_gears.3mf", 25692, "closed, 92 flat triangles; 17 bodies"},
      {"3mf/multiple_cylinders.3mf", 528, "closed, 6 bodies"},
      {"env/staircases_koroibot_hr.dae", 1276, "closed, 69 bodies"},
      {"ur5/visual/wrist3.dae", 1658, "closed, 5 bodies"},
      {"tools/cordless_drill.dae", 1126, "closed, 1 flat triangle; 2 bodies"},
      {"trimesh/simple_pole.glb", 580, "closed, 11 bodies"},
      {"classic/bob_small.ply", 500, "closed, 1 body"},
      {"bad/featuretype.STL", 3476, "576 open edges; 1 body"},
      {"bad/moebius.obj", 448, "112 open edges, 4 flipped edges; 1 body"},
      {"bad/triple_vierbein.obj", 108,
       "60 open edges, 20 non-manifold edges, 3 flipped edges; 1 body"},
      {"bad/soup.stl", 100, "300 open edges; 100 bodies"},
  };
  std::vector<fs::path> files;
  files.reserve(facts.size());
  for (const Fact& fact : facts) files.push_back(folder_ / fact.file);
  ForEach(files, [&](const fs::path& file) {
    const Fact& fact = *std::find_if(facts.begin(), facts.end(), [&](const Fact& f) {
      return folder_ / f.file == file;
    });
    const Result<TriangleMesh> mesh = ImportMesh(file);
    ASSERT_TRUE(mesh) << mesh.error().what;
    EXPECT_EQ(mesh->triangles.size(), fact.triangles) << file;
    EXPECT_EQ(Describe(Diagnose(*mesh)), fact.diagnosis) << file;
  });
}

TEST_F(ThirdPartyModels, CrackedSeamsCloseWithinATolerance) {
  const fs::path file = folder_ / "bad/featuretype.STL";
  const Result<TriangleMesh> exact = ImportMesh(file);
  ASSERT_TRUE(exact) << exact.error().what;
  const double tolerance = 1e-6 * BoundsOf(*exact).size().norm();
  const Result<TriangleMesh> welded = ImportMesh(file, {.weld_tolerance = tolerance});
  ASSERT_TRUE(welded) << welded.error().what;
  EXPECT_EQ(Describe(Diagnose(*exact)), "576 open edges; 1 body");
  EXPECT_EQ(Describe(Diagnose(*welded)), "closed, 1 body");
}

TEST_F(ThirdPartyModels, HaveTheVolumesOfTheirDimensions) {
  const std::vector<std::pair<const char*, double>> boxes{{"3mf/box.3mf", 10.0 * 20 * 30},
                                                          {"trimesh/unit_cube.STL", 1},
                                                          {"bad/CubeInvalidUnicode.stl", 8}};
  for (const auto& [name, volume] : boxes) {
    const Result<TriangleMesh> mesh = ImportMesh(folder_ / name);
    ASSERT_TRUE(mesh) << mesh.error().what;
    EXPECT_NEAR(ComputeMassProperties(*mesh).volume / volume, 1, 1e-6) << name;
  }
}

// The same link as an STL and as a COLLADA file with Z up, whose axes assimp would turn.
TEST_F(ThirdPartyModels, KeepTheAxesOfTheirFiles) {
  const Result<TriangleMesh> stl = ImportMesh(folder_ / "ur5/collision/base.stl");
  const Result<TriangleMesh> dae = ImportMesh(folder_ / "ur5/visual/base.dae");
  ASSERT_TRUE(stl) << stl.error().what;
  ASSERT_TRUE(dae) << dae.error().what;
  EXPECT_LE((BoundsOf(*stl).size() - BoundsOf(*dae).size()).norm(), 1e-3);
  EXPECT_LE((BoundsOf(*stl).centre() - BoundsOf(*dae).centre()).norm(), 1e-3);
}

}  // namespace
}  // namespace tandem
