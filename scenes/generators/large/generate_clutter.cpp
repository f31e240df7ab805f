#include <cstdio>
#include <filesystem>
#include <optional>

#include "scenes/generators/generator_command.h"
#include "scenes/generators/large/clutter.h"
#include "scenes/generators/large/seeded_poses.h"

namespace tandem {
namespace {

constexpr int kPosesOfEachKind = 20;

std::optional<Error> WritePosesOf(const PosedPair& pair, const std::filesystem::path& file) {
  return WritePoses(pair, SeededPoses(pair, kPosesOfEachKind), file);
}

/// Writes the bracket's poses. Its scene has several fixed meshes; other engines get them as one.
std::optional<Error> WriteBracketPoses(const std::filesystem::path& folder) {
  const GeneratedScene scene = BracketActuator();
  GeneratedScene merged{"bracket_actuator", {{"bracket_actuator_fixed.stl", {}}}, {}};
  for (std::size_t k = 0; k + 1 < scene.meshes.size(); ++k) {
    Append(merged.meshes[0].mesh, scene.meshes[k].mesh);
  }
  if (const auto fault = WriteScene(merged, folder)) return fault;
  return WritePosesOf({.fixed_file = merged.meshes[0].file,
                       .moving_file = scene.meshes.back().file,
                       .fixed = &merged.meshes[0].mesh,
                       .moving = &scene.meshes.back().mesh,
                       .push = {0, 0, 1},  // the collar's ears under the web
                       .spread = 1.5,
                       .out = {0, 0, 200}},
                      folder / "bracket_actuator_poses.csv");
}

std::optional<Error> Generate(const std::filesystem::path& folder) {
  const std::vector<TriangleMesh> parts = ClutterParts(ClutterShape{});
  const GeneratedScene scene = Clutter(parts);
  PrintSizes(parts, scene);
  if (const auto fault = WriteScene(scene, folder)) return fault;
  // downwards onto the racks
  if (const auto fault = WritePosesOf({.fixed_file = scene.meshes[0].file,
                                       .moving_file = scene.meshes[1].file,
                                       .fixed = &scene.meshes[0].mesh,
                                       .moving = &scene.meshes[1].mesh,
                                       .push = {0, 0, -1},
                                       .spread = 0.7,
                                       .out = {0, 0, 400}},
                                      folder / "clutter_poses.csv")) {
    return fault;
  }
  return WriteBracketPoses(folder);
}

}  // namespace
}  // namespace tandem

// generate_clutter FOLDER: writes the files that clutter.json in FOLDER names. For the comparisons
// with other engines it also writes the poses of this scene and of the bracket's.
int main(int argc, char** argv) {
  int exit_code = 0;
  const auto folder =
      tandem::FolderToFill(argc, argv, "generate_clutter",
                           "writes the files that clutter.json in FOLDER names", exit_code);
  if (!folder) return exit_code;
  if (const auto fault = tandem::Generate(*folder)) {
    std::fprintf(stderr, "%s\n", fault->what.c_str());
    return 1;
  }
  return 0;
}
