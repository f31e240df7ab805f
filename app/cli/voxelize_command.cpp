#include <atomic>
#include <charconv>
#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>
#include <tbb/global_control.h>
#include <unistd.h>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "app/common/stop_signal.h"
#include "engine/base/hash.h"
#include "engine/base/peak_memory.h"
#include "engine/base/text/json_text.h"
#include "engine/base/units.h"
#include "engine/contact/kept/surface_file.h"
#include "engine/geometry/exact/union_mass.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/geometry/import/unit_hint.h"
#include "engine/geometry/mesh/mesh_diagnosis.h"
#include "engine/realtime/clock.h"
#include "engine/voxel/build/voxelize.h"
#include "engine/voxel/map/voxmap_file.h"
#include "engine/voxel/points/pointshell.h"

namespace tandem {

namespace {

struct VoxelizeArguments {
  std::string file;
  std::string voxel = "auto";
  std::optional<double> scale;
  int range = kDefaultRange;
  int bits = 0;  // 0: the least that hold the range
  std::string out;
  std::string surface;
  std::uint64_t max_memory = PeakMemory();
  std::size_t threads = 0;
  bool json = false;
};

/// Returns a function that shows a person the progress and asks `stop` to stop on Ctrl-C.
std::function<void(double)> Watch(std::stop_source& stop) {
  const std::atomic<bool>& stop_asked = StopOnSignals();
  const bool shown = isatty(STDERR_FILENO) != 0;
  return [shown, &stop, &stop_asked, percent = -1](double share) mutable {
    if (stop_asked.load()) stop.request_stop();
    const int now = static_cast<int>(100 * share);
    if (!shown || now == percent) return;
    percent = now;
    std::fprintf(stderr, "\rvoxelizing: %d %%", now);
    if (now == 100) std::fprintf(stderr, "\r                   \r");
  };
}

std::optional<double> AsNumber(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Writes the surface for refined contact to a file. Returns its size in bytes.
Result<std::size_t> WriteSurface(const VoxelizeArguments& arguments, const TriangleMesh& mesh,
                                 double voxel_size, const std::stop_token& stop) {
  const SurfaceOptions options{
      .voxel_size = voxel_size, .max_memory_bytes = arguments.max_memory, .stop = stop};
  const Result<BodySurface> surface = BuildSurface(mesh, Pose{}, options);
  if (!surface) return Error{arguments.file + ": " + surface.error().what};
  if (const auto fault = SaveSurface(*surface, mesh, options, arguments.surface)) return *fault;
  return surface->field.bytes().size() + surface->features.bytes().size();
}

/// A voxelized mesh and its figures.
struct Voxelized {
  TriangleMesh mesh;
  MeshDiagnosis diagnosis;
  UnionMass mass;
  std::vector<std::string> remarks;
  std::size_t threads = 0;
  double seconds = 0;
  VoxelCounts counts;
  VoxelCounts unmerged;  // without merging, where every edge of every triangle is a feature
  std::size_t polygons = 0;
  std::size_t points = 0;
  std::size_t surface_bytes = 0;
  std::uint64_t digest = 0;
};

/// Voxelizes the mesh, makes its points and writes the files that the options name. Returns the
/// exit code.
int MakeVoxels(const VoxelizeArguments& arguments, VoxelizeOptions options, Voxelized& made) {
  const std::int64_t start_ns = MonotonicNowNs();
  std::stop_source stop;
  options.stop = stop.get_token();
  options.progress = Watch(stop);
  const TriangleMesh& mesh = made.mesh;
  const MeshSides sides(mesh);
  const Features features = FindFeatures(mesh, sides, options.flatness_voxels * options.voxel_size);
  const Result<Voxmap> voxmap = Voxelize(mesh, sides, features, options);
  if (!voxmap) return Fail(kExitFile, arguments.file + ": " + voxmap.error().what);
  if (const std::string hint = UnitHint(arguments.file, mesh, arguments.scale); !hint.empty()) {
    Say(arguments.file + ": " + hint);
  }
  if (!arguments.out.empty()) {
    if (const auto fault = SaveVoxmap(*voxmap, arguments.out)) return Fail(kExitFile, fault->what);
  }
  if (!arguments.surface.empty()) {
    const Result<std::size_t> bytes =
        WriteSurface(arguments, mesh, options.voxel_size, options.stop);
    if (!bytes) return Fail(kExitFile, bytes.error().what);
    made.surface_bytes = *bytes;
  }
  const Result<Pointshell> points =
      MakePointshell(mesh, features, Pose{},
                     {.spacing = options.voxel_size, .max_memory_bytes = arguments.max_memory});
  if (!points) return Fail(kExitFile, arguments.file + ": " + points.error().what);
  made.seconds = ToSeconds(MonotonicNowNs() - start_ns);

  const Result<Voxmap> unmerged = Voxelize(mesh, sides, FindFeatures(mesh, sides, 0.0), options);
  if (!unmerged) return Fail(kExitFile, arguments.file + ": " + unmerged.error().what);
  made.counts = voxmap->Count();
  made.unmerged = unmerged->Count();
  made.polygons = features.polygons;
  made.points = points->size();
  Hash64 digest;
  digest.Add(voxmap->Digest());
  digest.Add(Digest(*points));
  made.digest = digest.value();
  return kExitOk;
}

nlohmann::ordered_json VoxelizedJson(const VoxelizeArguments& arguments,
                                     const VoxelizeOptions& options, const Voxelized& made) {
  return {{"file", arguments.file},
          {"triangles", made.mesh.triangles.size()},
          {"bodies", made.diagnosis.bodies},
          {"closed", made.diagnosis.closed()},
          {"open_edges", made.diagnosis.open_edges},
          {"seconds", made.seconds},
          {"threads", made.threads},
          {"voxels",
           {{"interior", made.counts.interior},
            {"surface", made.counts.surface},
            {"free", made.counts.free},
            {"total", made.counts.total()}}},
          {"polygons", made.polygons},
          {"edge_voxels", made.counts.edge},
          {"vertex_voxels", made.counts.vertex},
          {"edge_voxels_unmerged", made.unmerged.edge},
          {"vertex_voxels_unmerged", made.unmerged.vertex},
          {"planes", made.counts.planes},
          {"hyperchunks", made.counts.hyperchunks},
          {"bytes", made.counts.bytes},
          {"surface_bytes", made.surface_bytes},
          {"points", {{"total", made.points}}},
          {"volume_m3", made.mass.volume},
          {"remarks", made.remarks},
          {"voxel_m", options.voxel_size},
          {"range_voxels", options.range},
          {"bits", options.bits},
          {"digest", Hex(made.digest)}};
}

void PrintVoxelized(const VoxelizeArguments& arguments, const VoxelizeOptions& options,
                    const Voxelized& made) {
  const Vec3 size = BoundsOf(made.mesh).size();
  PrintLine("%s: %s, %s, %.6g x %.6g x %.6g m, %.6g m^3%s", arguments.file.c_str(),
            WithPlural(made.mesh.triangles.size(), "triangle").c_str(),
            Describe(made.diagnosis).c_str(), size.x(), size.y(), size.z(), made.mass.volume,
            made.mass.solid ? "" : " (its surface encloses no sound volume)");
  PrintLine("voxels of %.6g m: %zu surface, %zu free, %zu interior, in %zu planes, %.1f MB",
            options.voxel_size, made.counts.surface, made.counts.free, made.counts.interior,
            made.counts.planes, 1e-6 * static_cast<double>(made.counts.bytes));
  if (!arguments.surface.empty()) {
    PrintLine("surface for refined contact: %.1f MB",
              1e-6 * static_cast<double>(made.surface_bytes));
  }
  PrintLine("%s of %s: %zu edge and %zu vertex voxels instead of %zu and %zu",
            WithPlural(made.polygons, "polygon").c_str(),
            WithPlural(made.mesh.triangles.size(), "triangle").c_str(), made.counts.edge,
            made.counts.vertex, made.unmerged.edge, made.unmerged.vertex);
  PrintLine("%s; %.3f s on %s; digest %s", WithPlural(made.points, "point").c_str(), made.seconds,
            WithPlural(made.threads, "thread").c_str(), Hex(made.digest).c_str());
}

int RunVoxelize(const VoxelizeArguments& arguments) {
  const std::optional<double> given = AsNumber(arguments.voxel);
  Voxelized made;
  Result<TriangleMesh> mesh =
      ImportAndTell(arguments.file, {.scale = arguments.scale}, &made.remarks);
  if (!mesh) return Fail(kExitFile, mesh.error().what);
  made.mesh = *std::move(mesh);
  made.diagnosis = Diagnose(made.mesh);
  made.mass = ComputeUnionMass(made.mesh);
  if (made.mass.counts_twice) {
    made.remarks.push_back(std::string("its volume ") + kCountsTwice);
    Say(arguments.file + ": " + made.remarks.back());
  }
  made.threads =
      arguments.threads > 0
          ? arguments.threads
          : tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, made.threads);
  VoxelizeOptions options{.voxel_size = given ? *given : AutoVoxelSize(made.mesh),
                          .range = arguments.range,
                          .bits = arguments.bits > 0 ? arguments.bits : BitsFor(arguments.range),
                          .max_memory_bytes = arguments.max_memory};
  if (options.range > WidestRange(options.bits)) {
    return Fail(kExitUsage, "--bits " + std::to_string(options.bits) +
                                " holds a range of at most " +
                                std::to_string(WidestRange(options.bits)) +
                                " voxels: give more bits, or a --range within that");
  }
  if (const auto fault = VoxelSizeFault(made.mesh, options)) {
    return Fail(kExitFile, arguments.file + ": " + fault->what +
                               AndUnitHint(arguments.file, made.mesh, arguments.scale));
  }
  if (const int failed = MakeVoxels(arguments, options, made); failed != kExitOk) return failed;
  if (arguments.json) {
    const nlohmann::ordered_json out = VoxelizedJson(arguments, options, made);
    PrintText(JsonText(out, 2));
  } else {
    PrintVoxelized(arguments, options, made);
  }
  return kExitOk;
}

}  // namespace

void AddVoxelizeCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<VoxelizeArguments>();
  CLI::App* command =
      app.add_subcommand("voxelize", "Voxelize a mesh file and describe the result");
  command
      ->add_option(
          "file", arguments->file,
          "mesh file: STL, OBJ, PLY, OFF, 3MF, AMF, glTF, COLLADA, or another that assimp reads")
      ->required();
  command
      ->add_option("--voxel", arguments->voxel,
                   "voxel size, m, or auto: a two-hundredth of the longest side")
      ->check(CLI::Validator(
          [](std::string& text) -> std::string {
            if (text == "auto") return "";
            const std::string fault = NumberFrom(kLeastVoxel, kLargestVoxel)(text);
            return fault.empty() ? "" : "auto, or " + fault;
          },
          "auto or metres"));
  command->add_option("--scale", arguments->scale, kScaleHelp)
      ->check(NumberFrom(kLeastScale, kLargestScale));
  command->add_option("--range", arguments->range, "range of the distance fields, voxels")
      ->check(WholeNumberFrom(1, WidestRange(8)))
      ->capture_default_str();
  command
      ->add_option("--bits", arguments->bits,
                   "size of a mark, bits: 2, 4 or 8; default: the smallest that holds --range")
      ->check(OneOf({"2", "4", "8"}));
  command->add_option("--out", arguments->out,
                      "voxmap file to write: one image that programs map into memory");
  command->add_option(
      "--surface", arguments->surface,
      "surface file for refined contact to write, which programs map into memory too");
  command
      ->add_option("--max-memory", arguments->max_memory,
                   "most memory to use: bytes, or with a unit (8GiB); default: three quarters of "
                   "the machine's")
      ->transform(SizeInBytes());
  command
      ->add_option("--threads", arguments->threads, "number of threads; 0: one for each processor")
      ->check(WholeNumberFrom(0, kMostThreads));
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunVoxelize(*arguments);
  });
}

}  // namespace tandem
