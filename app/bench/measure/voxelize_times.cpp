#include "app/bench/measure/voxelize_times.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "app/bench/measure/bench_scene.h"
#include "app/common/scene_files.h"
#include "app/picture/chart.h"
#include "app/process/child_processes.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/voxel/build/voxelize.h"
#include "engine/voxel/map/voxmap_file.h"
#include "engine/voxel/points/pointshell.h"

namespace tandem {

namespace {

constexpr double kPaperShift = 0.5;  // voxels, shift of the ball's points (paper section 7)

/// The bodies of a scene: the body in hand, and all others.
struct TwoMeshes {
  TriangleMesh moving;
  TriangleMesh fixed;
};
Result<TwoMeshes> ReadMeshes(const Scene& scene) {
  const bool any_fixed = std::ranges::any_of(scene.bodies, [](const SceneBody& body) {
    return body.fixed;
  });
  const int in_hand = scene.hands.empty() ? -1 : scene.BodyNamed(scene.hands[0].body);
  TwoMeshes meshes;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    Result<TriangleMesh> mesh = ImportAndTell(body.mesh, {.scale = body.scale, .part = body.part});
    if (!mesh) return mesh.error();
    const bool fixed = any_fixed ? body.fixed : static_cast<int>(i) != in_hand;
    Append(fixed ? meshes.fixed : meshes.moving, Transformed(*mesh, body.X_WM));
  }
  return meshes;
}

}  // namespace

Result<SceneTimes> TimeScene(const std::string& scene_name, double voxel_size,
                             double point_spacing) {
  const Result<Scene> scene = LoadNamedScene(scene_name);
  if (!scene) return scene.error();
  SceneTimes times;
  Result<TwoMeshes> meshes = Error{};
  times.load_s = 1e-9 * WallNs([&] {
                   meshes = ReadMeshes(*scene);
                 });
  if (!meshes) return meshes.error();
  times.moving_triangles = meshes->moving.triangles.size();
  times.fixed_triangles = meshes->fixed.triangles.size();

  Result<Voxmap> voxels = Error{};
  Result<Pointshell> points = Error{};
  times.voxelize_s = 1e-9 * WallNs([&] {
                       voxels = Voxelize(meshes->fixed, {.voxel_size = voxel_size});
                     });
  if (!voxels) return Error{scene_name + ": " + voxels.error().what};
  const double points_s =
      1e-9 * WallNs([&] {
        points = MakePointshell(
            meshes->moving, Pose{},
            {.spacing = point_spacing,
             .inward_shift = point_spacing == voxel_size ? kPaperShift * voxel_size : 0});
      });
  if (!points) return Error{scene_name + ": " + points.error().what};
  times.voxelize_s += points_s;
  times.load_s += points_s;
  times.points = points->size();
  times.voxels = voxels->Count();

  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "fixed.voxmap";
  if (const auto fault = SaveVoxmap(*voxels, file)) return *fault;
  voxels = Error{};
  times.load_s += 1e-9 * WallNs([&] {
                    voxels = MapVoxmap(file);
                  });
  if (!voxels) return voxels.error();
  return times;
}

Result<TriangleMesh> FixedMeshOf(const std::string& scene_name) {
  const Result<Scene> scene = LoadNamedScene(scene_name);
  if (!scene) return scene.error();
  Result<TwoMeshes> meshes = ReadMeshes(*scene);
  if (!meshes) return meshes.error();
  return std::move(meshes->fixed);
}

Result<VoxelizeTime> TimeVoxelize(const TriangleMesh& mesh, double voxel_size) {
  VoxelizeTime time{.voxel_size = voxel_size, .seconds = 1e300, .voxels = 0};
  for (int run = 0; run < 2; ++run) {
    Result<Voxmap> voxels = Error{};
    const double seconds = 1e-9 * WallNs([&] {
                             voxels = Voxelize(mesh, {.voxel_size = voxel_size});
                           });
    if (!voxels) return voxels.error();
    time.seconds = std::min(time.seconds, seconds);
    time.voxels = voxels->Count().total();
  }
  return time;
}

PowerLaw FitPowerLaw(const std::vector<VoxelizeTime>& times) {
  double n = 0;
  double x = 0;
  double y = 0;
  double xx = 0;
  double xy = 0;
  for (const VoxelizeTime& time : times) {
    const double log_size = std::log(1e3 * time.voxel_size);
    const double log_time = std::log(time.seconds);
    n += 1;
    x += log_size;
    y += log_time;
    xx += log_size * log_size;
    xy += log_size * log_time;
  }
  const double exponent = (n * xy - x * y) / (n * xx - x * x);
  return {.factor = std::exp((y - exponent * x) / n), .exponent = exponent};
}

Picture Figure10Picture(const std::vector<VoxelizeTime>& times, const PowerLaw& law) {
  constexpr Rgb kBlue{0, 114, 178};
  constexpr Rgb kGrey{120, 120, 120};
  Picture picture{.name = "figure10",
                  .title = "Voxelization time against voxel size",
                  .width = 640,
                  .height = 420,
                  .shapes = {}};
  picture.shapes.emplace_back(
      RectangleShape{.box = {0, 0, 640, 420}, .fill = kWhite, .edge = {}, .hint = {}});
  double finest = 1e300;
  double coarsest = 0;
  double least = 1e300;
  double most = 0;
  for (const VoxelizeTime& time : times) {
    finest = std::min(finest, 1e3 * time.voxel_size);
    coarsest = std::max(coarsest, 1e3 * time.voxel_size);
    least = std::min(least, time.seconds);
    most = std::max(most, time.seconds);
  }
  Chart chart(
      picture, {80, 20, 530, 330},
      {.label = "voxel size, mm", .from = 0.8 * finest, .to = 1.25 * coarsest, .logarithmic = true},
      {.label = "time, s", .from = 0.6 * least, .to = 1.6 * most, .logarithmic = true});
  chart.DrawGrid();
  std::vector<PicturePoint> line;
  for (const double size : {finest, coarsest}) {
    line.push_back({size, law.factor * std::pow(size, law.exponent)});
  }
  const Stroke dashed{.colour = kGrey, .width = 1.5, .dashes = {6, 4}};
  chart.DrawCurve(line, dashed);
  for (const VoxelizeTime& time : times) {
    picture.shapes.emplace_back(MarkerShape{.at = chart.At(1e3 * time.voxel_size, time.seconds),
                                            .kind = MarkerKind::kDot,
                                            .size = 8,
                                            .colour = kBlue,
                                            .hint = ShortNumber(time.seconds) + " s"});
  }
  chart.DrawAxes();
  char text[64];
  std::snprintf(text, sizeof text, "the power of %.2f of the voxel size", law.exponent);
  DrawLegendLine(picture, {330, 45}, dashed, text);
  return picture;
}

}  // namespace tandem
