#include "app/peer/current_scene.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>

#include "engine/base/files/regular_file.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// Writes a scene of two bodies into a folder of that name, and saves it beside that as it stands.
Result<bool> SavedFrom(const ScratchFolder& scratch, const std::string& name, const fs::path& saved,
                       const std::optional<AddedBody>& added = {}) {
  const fs::path folder = scratch.path() / name;
  fs::create_directories(folder);
  for (const char* mesh : {"base.stl", "part.stl"}) std::ofstream(folder / mesh) << "solid";
  const fs::path file = scratch.Write(name + "/scene.json", R"({"name": "s", "voxel_m": 0.001,
      "bodies": [{"name": "base", "mesh": "base.stl", "fixed": true},
                 {"name": "part", "mesh": "part.stl", "mass_kg": 1}]})");
  const Result<Scene> scene = LoadScene(file);
  EXPECT_TRUE(scene) << scene.error().what;
  if (!scene) return scene.error();
  return WriteCurrentScene(*scene, std::vector<Pose>(scene->bodies.size()), added, saved, false);
}

TEST(CurrentScene, NamesItsMeshesByAbsolutePaths) {
  const ScratchFolder scratch;
  const fs::path saved = scratch.path() / "saved.json";
  const Result<bool> written = SavedFrom(scratch, "b\xC3\xA9", saved);
  ASSERT_TRUE(written) << written.error().what;
  const Result<Scene> again = LoadScene(saved);
  ASSERT_TRUE(again) << again.error().what;
  EXPECT_EQ(again->bodies[1].mesh, scratch.path() / "b\xC3\xA9" / "part.stl");
}

// JSON is UTF-8. With a replacement for a byte the scene would name a mesh that does not exist.
TEST(CurrentScene, IsNotSavedWithoutMeshPaths) {
  const ScratchFolder scratch;
  const fs::path saved = scratch.path() / "saved.json";
  const Result<bool> written = SavedFrom(scratch, "b\xE9", saved);
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().what, HasSubstr("b?/base.stl: a scene cannot name this file"));
  const Result<bool> of_added =
      SavedFrom(scratch, "b", saved, AddedBody{.name = "new", .mesh = "/b\xE9.stl"});
  ASSERT_FALSE(of_added);
  EXPECT_THAT(of_added.error().what, HasSubstr("/b?.stl: a scene cannot name this file"));
  EXPECT_FALSE(fs::exists(saved));
}

}  // namespace
}  // namespace tandem
