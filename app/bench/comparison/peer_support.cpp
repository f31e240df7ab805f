#include "app/bench/comparison/peer_support.h"

#include <algorithm>
#include <cstdio>
#include <ctime>

#include "app/common/exit_codes.h"
#include "app/common/scene_files.h"
#include "engine/base/units.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/geometry/mesh/mass_properties.h"
#include "engine/realtime/clock.h"
#include "engine/world/world_model.h"

namespace tandem {

int RunPeer(CLI::App& app, int argc, char** argv,
            const std::function<std::optional<Error>()>& run) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitUsage;
  }
  if (const auto fault = run()) {
    std::fprintf(stderr, "%s\n", fault->what.c_str());
    return kExitFile;
  }
  return kExitOk;
}

void AddPeerPair(CLI::App& app, PeerPair& pair) {
  app.add_option("fixed", pair.fixed, "mesh file of the fixed part")->required();
  app.add_option("moving", pair.moving, "mesh file of the moving part")->required();
  app.add_option("poses", pair.poses, "CSV file of poses, in file units")->required();
  app.add_option("--scale", pair.scale, "metres per file unit")->capture_default_str();
  app.add_option("--voxel", pair.voxel, "voxel size of the map, m")->capture_default_str();
  app.add_option("--spacing", pair.spacing, "spacing of the points, m; default: the voxel size");
}

Result<PeerModels> LoadPeerModels(const PeerPair& pair, ContactModel model) {
  // a busy machine may take a while over a large file
  const ImportOptions import{.scale = pair.scale, .seconds_limit = 60};
  Result<TriangleMesh> fixed = ImportAndTell(pair.fixed, import);
  if (!fixed) return fixed.error();
  Result<TriangleMesh> moving = ImportAndTell(pair.moving, import);
  if (!moving) return moving.error();
  Result<std::vector<FilePose>> poses = ReadPosesFile(pair.poses);
  if (!poses) return poses.error();
  std::erase_if(*poses, [&](const FilePose& pose) {
    return pose.fixed != pair.fixed.filename() || pose.moving != pair.moving.filename();
  });
  if (poses->empty())
    return Error{pair.poses.string() + ": the file has no pose of these two files"};
  for (FilePose& pose : *poses) pose.X_WM.p *= pair.scale;

  PeerModels models{.fixed = std::move(*fixed),
                    .moving = std::move(*moving),
                    .voxmap = {},
                    .points = {},
                    .fixed_surface = {},
                    .moving_surface = {},
                    .X_MB = {},
                    .poses = std::move(*poses)};
  models.X_MB.p = ComputeMassProperties(models.moving).p_MBo;
  Scene scene;
  scene.contact = model;
  scene.voxel_size = pair.voxel;
  if (const auto fault = MakeMap(scene, models.fixed, models.voxmap)) return *fault;
  if (model == ContactModel::kRefined) {
    const double spacing = pair.spacing > 0 ? pair.spacing / pair.voxel : 1;
    Result<BodySurface> map = MakeSurface(scene, models.fixed, Pose{});
    if (!map) return map.error();
    models.fixed_surface = std::move(*map);
    Result<BodySurface> shell = MakeSurface(scene, models.moving, models.X_MB, spacing);
    if (!shell) return shell.error();
    models.moving_surface = std::move(*shell);
  }
  if (pair.spacing > 0) scene.voxel_size = pair.spacing;
  Result<Pointshell> points = MakePoints(scene, models.moving, models.X_MB, 0);
  if (!points) return points.error();
  models.points = std::move(*points);
  return models;
}

double ProcessCpuNs() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return 1e9 * static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec);
}

Timed Repeated(const std::function<void()>& work, double cpu_s) {
  std::vector<double> cpu;
  std::vector<double> wall;
  double used = 0;
  while (used < cpu_s || cpu.size() < 3) {
    const double cpu_begin = ProcessCpuNs();
    const std::int64_t wall_begin = MonotonicNowNs();
    work();
    wall.push_back(ToSeconds(MonotonicNowNs() - wall_begin));
    cpu.push_back(1e-9 * (ProcessCpuNs() - cpu_begin));
    used += cpu.back();
  }
  return {MedianOf(cpu), MedianOf(wall), static_cast<int>(cpu.size())};
}

double MedianOf(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace tandem
