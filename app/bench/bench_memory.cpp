#include <cstdio>
#include <filesystem>
#include <memory>

#include <nlohmann/json.hpp>

#include "app/bench/bench_commands.h"
#include "app/bench/measure/bench_scene.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

struct MemoryArguments {
  std::vector<std::string> scenes{"bracket_actuator", "clutter"};
  double voxel_size = 0;
  bool json = false;
};

/// The figures of the maps of one scene together.
struct Row {
  std::string scene;
  double voxel_size = 0;
  std::size_t band_voxels = 0;
  std::size_t planes = 0;
  std::size_t bytes = 0;
  std::size_t surface_bytes = 0;  // fields, lists and features of refined contact

  double PerBandVoxel(std::size_t of_them) const {
    return static_cast<double>(of_them) /
           static_cast<double>(std::max<std::size_t>(1, band_voxels));
  }
  double bytes_per_band_voxel() const { return PerBandVoxel(bytes); }
  double of_surfaces() const { return PerBandVoxel(surface_bytes); }
};

int RunMemoryBench(const MemoryArguments& arguments) {
  std::vector<Row> rows;
  for (const std::string& name : arguments.scenes) {
    const Result<std::shared_ptr<const WorldModel>> world = LoadBenchScene(
        {.scene = name, .voxel_size = arguments.voxel_size, .needs_plain_parts = true});
    if (!world) return Fail(kExitFile, world.error().what);
    Row row{.scene = name};
    const auto add = [&row](const Voxmap& voxmap, const BodySurface& surface) {
      if (voxmap.empty()) return;
      const VoxelCounts counts = voxmap.Count();
      row.voxel_size = voxmap.voxel_size();
      row.band_voxels += counts.band;
      row.planes += counts.planes;
      row.bytes += counts.bytes;
      row.surface_bytes += surface.field.Count().bytes() + surface.features.bytes().size();
    };
    add((*world)->fixture, (*world)->fixture_surface);
    for (const BodyModel& body : (*world)->bodies) add(body.voxmap, body.surface);
    rows.push_back(row);
  }
  double worst = 0;
  for (const Row& row : rows) worst = std::max(worst, row.bytes_per_band_voxel());
  if (arguments.json) {
    nlohmann::ordered_json scenes = nlohmann::ordered_json::array();
    for (const Row& row : rows) {
      scenes.push_back({{"scene", row.scene},
                        {"voxel_m", row.voxel_size},
                        {"band_voxels", row.band_voxels},
                        {"planes", row.planes},
                        {"bytes", row.bytes},
                        {"surface_bytes", row.surface_bytes},
                        {"bytes_per_band_voxel", row.bytes_per_band_voxel()},
                        {"bytes_per_band_voxel_refined", row.of_surfaces()},
                        {"resident_bytes_per_band_voxel", row.of_surfaces()}});
    }
    const nlohmann::ordered_json out{{"bytes_per_band_voxel", worst}, {"scenes", scenes}};
    std::printf("%s\n", JsonText(out, 2).c_str());
    return kExitOk;
  }
  for (const Row& row : rows) {
    std::printf(
        "%s, voxels of %g m: %zu band voxels, %zu planes, %.1f MB, %.3f bytes a band voxel; "
        "distance fields and features %.1f MB, %.3f\n",
        row.scene.c_str(), row.voxel_size, row.band_voxels, row.planes,
        1e-6 * static_cast<double>(row.bytes), row.bytes_per_band_voxel(),
        1e-6 * static_cast<double>(row.surface_bytes), row.of_surfaces());
  }
  return kExitOk;
}

}  // namespace

void AddBenchMemory(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<MemoryArguments>();
  CLI::App* command =
      bench.add_subcommand("memory", "Measure the memory of voxel maps per voxel of their band");
  command->add_option("--scene", arguments->scenes, "scenes to measure, by name or file")
      ->capture_default_str();
  command->add_option("--voxel", arguments->voxel_size, "voxel size, m; default: the scene's")
      ->check(NumberFrom(kLeastVoxel, kLargestVoxel));
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunMemoryBench(*arguments);
  });
}

}  // namespace tandem
