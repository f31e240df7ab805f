#include <cstdio>
#include <ctime>
#include <memory>

#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

#include "app/cli/bench.h"
#include "app/cli/mesh_unit.h"
#include "app/cli/talk.h"
#include "app/exit_codes.h"
#include "app/option_checks.h"
#include "engine/base/json_text.h"
#include "engine/geometry/mesh_file.h"
#include "engine/voxel/voxelize.h"

namespace tandem {

namespace {

constexpr double kLeastSeconds = 2.0;  // of processor time, in all

struct VoxelizeBenchArguments {
  std::string file;
  double voxel_size = 0.001;
  std::optional<double> scale;
  std::size_t threads = 4;
  bool json = false;
};

/// Of all threads together, s.
double ProcessCpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

int RunVoxelizeBench(const VoxelizeBenchArguments& arguments) {
  const Result<TriangleMesh> mesh = ImportMesh(arguments.file, {.scale = arguments.scale});
  if (!mesh) return Fail(kExitFile, mesh.error().what);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, arguments.threads);
  const VoxelizeOptions options{.voxel_size = arguments.voxel_size};
  // the first run warms caches and threads and does not count
  Result<Voxmap> voxmap = Voxelize(*mesh, options);
  if (!voxmap) {
    return Fail(kExitFile, arguments.file + ": " + voxmap.error().what +
                               AndUnitHint(arguments.file, *mesh, arguments.scale));
  }
  std::vector<double> seconds;
  std::vector<double> cpu_seconds;
  for (double total = 0; total < kLeastSeconds || cpu_seconds.size() < 3;) {
    const double cpu = ProcessCpuSeconds();
    seconds.push_back(1e-9 * WallNs([&] {
                        voxmap = Voxelize(*mesh, options);
                      }));
    cpu_seconds.push_back(ProcessCpuSeconds() - cpu);
    total += cpu_seconds.back();
  }
  const VoxelCounts counts = voxmap->Count();
  const std::size_t band = counts.band;
  // without merging, every edge of every triangle would be a feature
  const MeshSides sides(*mesh);
  const Features merged = FindFeatures(*mesh, sides, options.flatness_voxels * options.voxel_size);
  const Result<Voxmap> unmerged = Voxelize(*mesh, sides, FindFeatures(*mesh, sides, 0.0), options);
  if (!unmerged) return Fail(kExitFile, arguments.file + ": " + unmerged.error().what);
  const VoxelCounts saved_of = unmerged->Count();
  const double per_band = static_cast<double>(counts.bytes) / static_cast<double>(band);
  const double per_chunk = static_cast<double>(counts.surface) /
                           static_cast<double>(std::max<std::size_t>(1, counts.surface_chunks));
  if (arguments.json) {
    const nlohmann::ordered_json out{{"file", arguments.file},
                                     {"voxel_m", arguments.voxel_size},
                                     {"threads", arguments.threads},
                                     {"triangles", mesh->triangles.size()},
                                     {"runs", seconds.size()},
                                     {"seconds", Median(seconds)},
                                     {"cpu_seconds", Median(cpu_seconds)},
                                     {"points_per_chunk", per_chunk},
                                     {"band_voxels", band},
                                     {"bytes", counts.bytes},
                                     {"bytes_per_band_voxel", per_band},
                                     {"polygons", merged.polygons},
                                     {"edge_voxels", counts.edge},
                                     {"vertex_voxels", counts.vertex},
                                     {"edge_voxels_unmerged", saved_of.edge},
                                     {"vertex_voxels_unmerged", saved_of.vertex}};
    std::printf("%s\n", JsonText(out, 2).c_str());
    return kExitOk;
  }
  std::printf("%s: %s, voxels of %g m, three fields, %s, median of %s\n", arguments.file.c_str(),
              Counted(mesh->triangles.size(), "triangle").c_str(), arguments.voxel_size,
              Counted(arguments.threads, "thread").c_str(), Counted(seconds.size(), "run").c_str());
  std::printf("%.4f s, %.4f s of processor time\n", Median(seconds), Median(cpu_seconds));
  std::printf("%zu band voxels, %.1f points a chunk, %.1f MB, %.3f bytes a band voxel\n", band,
              per_chunk, 1e-6 * static_cast<double>(counts.bytes), per_band);
  std::printf("%s: %zu edge and %zu vertex voxels instead of %zu and %zu\n",
              Counted(merged.polygons, "polygon").c_str(), counts.edge, counts.vertex,
              saved_of.edge, saved_of.vertex);
  return kExitOk;
}

}  // namespace

void AddBenchVoxelize(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<VoxelizeBenchArguments>();
  CLI::App* command = bench.add_subcommand("voxelize", "Time the voxelization of a mesh file");
  command->add_option("file", arguments->file, "mesh file")->required();
  command->add_option("--voxel", arguments->voxel_size, "voxel size in metres")
      ->check(NumberFrom(kLeastVoxel, kLargestVoxel))
      ->capture_default_str();
  command->add_option("--scale", arguments->scale, kScaleHelp)
      ->check(NumberFrom(kLeastScale, kLargestScale));
  command->add_option("--threads", arguments->threads, "threads")
      ->check(WholeNumberFrom(1, kMostThreads))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunVoxelizeBench(*arguments);
  });
}

}  // namespace tandem
