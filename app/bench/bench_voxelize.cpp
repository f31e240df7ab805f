#include <cstdio>
#include <ctime>
#include <memory>

#include <nlohmann/json.hpp>
#include <tbb/global_control.h>

#include "app/bench/bench_commands.h"
#include "app/bench/measure/bench_scene.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "engine/base/text/json_text.h"
#include "engine/contact/kept/surface_file.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/geometry/import/unit_hint.h"
#include "engine/voxel/build/voxelize.h"

namespace tandem {

namespace {

constexpr double kLeastSeconds = 2.0;  // least processor time in all

struct VoxelizeBenchArguments {
  std::string file;
  double voxel_size = 0.001;
  std::optional<double> scale;
  std::size_t threads = 4;
  std::string surface;
  bool json = false;
};

/// Returns the processor time of all threads together, s.
double ProcessCpuSeconds() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// The figures of the surface for refined contact: made once, written once, mapped some times.
struct SurfaceFigures {
  double build_s = 0;
  double build_cpu_s = 0;
  double save_s = 0;
  double map_s = 0;      // median
  double map_cpu_s = 0;  // median
  std::size_t field_bytes = 0;
  std::size_t feature_bytes = 0;
  bool same = false;  // the mapped surface equals the made one
};

Result<SurfaceFigures> TimeSurface(const TriangleMesh& mesh, double voxel_size,
                                   const std::string& file) {
  const SurfaceOptions options{.voxel_size = voxel_size};
  SurfaceFigures figures;
  const double cpu = ProcessCpuSeconds();
  Result<BodySurface> made = Error{};
  figures.build_s = 1e-9 * WallNs([&] {
                      made = BuildSurface(mesh, Pose{}, options);
                    });
  figures.build_cpu_s = ProcessCpuSeconds() - cpu;
  if (!made) return made.error();
  std::optional<Error> fault;
  figures.save_s = 1e-9 * WallNs([&] {
                     fault = SaveSurface(*made, mesh, options, file);
                   });
  if (fault) return *fault;
  figures.field_bytes = made->field.bytes().size();
  figures.feature_bytes = made->features.bytes().size();
  const std::uint64_t digest = made->field.Digest();
  made = Error{};
  std::vector<double> seconds;
  std::vector<double> cpu_seconds;
  for (int run = 0; run < 5; ++run) {
    const double begin = ProcessCpuSeconds();
    Result<BodySurface> mapped = Error{};
    seconds.push_back(1e-9 * WallNs([&] {
                        mapped = MapSurface(file, mesh, Pose{}, options);
                      }));
    cpu_seconds.push_back(ProcessCpuSeconds() - begin);
    if (!mapped) return mapped.error();
    figures.same = mapped->field.Digest() == digest;
  }
  figures.map_s = Median(seconds);
  figures.map_cpu_s = Median(cpu_seconds);
  return figures;
}

nlohmann::ordered_json AsJson(const SurfaceFigures& surface) {
  return {{"build_s", surface.build_s},
          {"build_cpu_s", surface.build_cpu_s},
          {"save_s", surface.save_s},
          {"map_s", surface.map_s},
          {"map_cpu_s", surface.map_cpu_s},
          {"field_bytes", surface.field_bytes},
          {"feature_bytes", surface.feature_bytes},
          {"same", surface.same}};
}

void Print(const SurfaceFigures& surface) {
  std::printf(
      "surface file for refined contact: made in %.3f s (%.3f s of processor time), written in "
      "%.3f s, mapped and checked in %.4f s; field %.1f MB, features %.1f MB%s\n",
      surface.build_s, surface.build_cpu_s, surface.save_s, surface.map_s,
      1e-6 * static_cast<double>(surface.field_bytes),
      1e-6 * static_cast<double>(surface.feature_bytes),
      surface.same ? "" : "; the mapped file differs");
}

int RunVoxelizeBench(const VoxelizeBenchArguments& arguments) {
  const Result<TriangleMesh> mesh = ImportAndTell(arguments.file, {.scale = arguments.scale});
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
  std::optional<SurfaceFigures> surface;
  if (!arguments.surface.empty()) {
    const Result<SurfaceFigures> timed =
        TimeSurface(*mesh, arguments.voxel_size, arguments.surface);
    if (!timed) return Fail(kExitFile, timed.error().what);
    surface = *timed;
  }
  const double per_band = static_cast<double>(counts.bytes) / static_cast<double>(band);
  const double per_chunk = static_cast<double>(counts.surface) /
                           static_cast<double>(std::max<std::size_t>(1, counts.surface_chunks));
  if (arguments.json) {
    nlohmann::ordered_json out{{"file", arguments.file},
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
    if (surface) out["surface"] = AsJson(*surface);
    std::printf("%s\n", JsonText(out, 2).c_str());
    return kExitOk;
  }
  std::printf("%s: %s, voxels of %g m, three fields, %s, median of %s\n", arguments.file.c_str(),
              WithPlural(mesh->triangles.size(), "triangle").c_str(), arguments.voxel_size,
              WithPlural(arguments.threads, "thread").c_str(),
              WithPlural(seconds.size(), "run").c_str());
  std::printf("%.4f s, %.4f s of processor time\n", Median(seconds), Median(cpu_seconds));
  std::printf("%zu band voxels, %.1f points a chunk, %.1f MB, %.3f bytes a band voxel\n", band,
              per_chunk, 1e-6 * static_cast<double>(counts.bytes), per_band);
  std::printf("%s: %zu edge and %zu vertex voxels instead of %zu and %zu\n",
              WithPlural(merged.polygons, "polygon").c_str(), counts.edge, counts.vertex,
              saved_of.edge, saved_of.vertex);
  if (surface) Print(*surface);
  return kExitOk;
}

}  // namespace

void AddBenchVoxelize(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<VoxelizeBenchArguments>();
  CLI::App* command =
      bench.add_subcommand("voxelize", "Measure the time of voxelizing a mesh file");
  command->add_option("file", arguments->file, "mesh file to voxelize")->required();
  command->add_option("--voxel", arguments->voxel_size, "voxel size, m")
      ->check(NumberFrom(kLeastVoxel, kLargestVoxel))
      ->capture_default_str();
  command->add_option("--scale", arguments->scale, kScaleHelp)
      ->check(NumberFrom(kLeastScale, kLargestScale));
  command->add_option("--threads", arguments->threads, "threads")
      ->check(WholeNumberFrom(1, kMostThreads))
      ->capture_default_str();
  command->add_option(
      "--surface", arguments->surface,
      "surface file for refined contact to write; its making and mapping are measured too");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunVoxelizeBench(*arguments);
  });
}

}  // namespace tandem
