#include "app/cli/bench.h"
#include "app/cli/commands.h"
#include "app/cli/scene_files.h"

namespace tandem {

void AddBenchScene(CLI::App& command, BenchScene& scene) {
  command.add_option("--scene", scene.scene, "a scene of tandem's by name, or a scene file")
      ->capture_default_str();
  command.add_option("--voxel", scene.voxel_size, "voxel size in metres; default: the scene's")
      ->check(CLI::PositiveNumber);
}

Result<std::shared_ptr<const WorldModel>> LoadBenchScene(const BenchScene& asked) {
  const std::filesystem::path file = SceneFile(asked.scene);
  if (asked.scene == "clutter" && !std::filesystem::exists(file)) {
    return Error{file.string() +
                 ": not there; `cmake --build --preset release --target clutter` makes it"};
  }
  Result<Scene> scene = LoadScene(file);
  if (!scene) return scene.error();
  if (asked.voxel_size > 0) scene->voxel_size = asked.voxel_size;
  return LoadWorld(*scene);
}

void AddBenchCommand(CLI::App& app, int& exit_code) {
  CLI::App* bench = app.add_subcommand("bench", "Measure the engine beside this machine's limits");
  bench->require_subcommand(1);
  AddBenchMemory(*bench, exit_code);
  AddBenchPoints(*bench, exit_code);
  AddBenchProximity(*bench, exit_code);
  AddBenchVoxelize(*bench, exit_code);
  AddBenchFidelity(*bench, exit_code);
}

}  // namespace tandem
