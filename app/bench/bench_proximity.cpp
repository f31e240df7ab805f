#include <cmath>
#include <cstdio>
#include <memory>
#include <random>

#include <nlohmann/json.hpp>

#include "app/bench/bench_commands.h"
#include "app/bench/measure/bench_scene.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/scene_files.h"
#include "app/judgement/proximity_bodies.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

constexpr int kPoses = 500;
constexpr std::size_t kVertices = 100'000;
constexpr std::size_t kMostShadow = 1'000'000;
constexpr double kShadowVoxels = 4;

struct ProximityArguments {
  BenchScene scene{.scene = "bracket_actuator"};
  bool json = false;
};

/// The times of single answers, ms of the thread's processor time.
struct Times {
  std::vector<double> ms;
  template <class Work>
  void Add(const Work& work) {
    ms.push_back(1e-6 * CpuNs(work));
  }
  double median() const { return Median(ms); }
  double worst() const { return *std::max_element(ms.begin(), ms.end()); }
  nlohmann::ordered_json json() const { return {{"median_ms", median()}, {"max_ms", worst()}}; }
};

struct ProximityFigures {
  Times colours, shadow, coarse, refined;
  std::size_t in_range = 0;     // vertices in range, over all poses
  std::size_t most_shadow = 0;  // voxels
  std::size_t unfinished = 0;   // searches by triangles that were cut short
};

/// Returns points evenly on a mesh's surface, as many as a fine mesh has vertices.
std::vector<std::array<float, 3>> PointsOn(const MeshTree& mesh) {
  std::vector<double> upto;
  double area = 0;
  for (const std::array<Vec3, 3>& t : mesh.triangles) {
    area += 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
    upto.push_back(area);
  }
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<std::array<float, 3>> points;
  for (std::size_t i = 0; i < kVertices; ++i) {
    const double at = area * (static_cast<double>(i) + share(random)) / kVertices;
    const auto found = std::lower_bound(upto.begin(), upto.end() - 1, at) - upto.begin();
    const std::array<Vec3, 3>& t = mesh.triangles[static_cast<std::size_t>(found)];
    const double u = std::sqrt(share(random));
    const double v = u * share(random);
    const Eigen::Vector3f p = (t[0] + u * (t[1] - t[0]) + v * (t[2] - t[1])).cast<float>();
    points.push_back({p.x(), p.y(), p.z()});
  }
  return points;
}

/// Returns a displacement within 10 voxels, and a turn that moves points as far again.
Pose RandomDisplacement(std::mt19937_64& random, const Bounds& box, double voxel) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share(0, 1);
  const Vec3 shift = Vec3(normal(random), normal(random), normal(random)).normalized();
  const Vec3 axis = Vec3(normal(random), normal(random), normal(random)).normalized();
  const double angle = 10 * voxel * share(random) / (0.5 * box.size().norm());
  const Quat q = RotationBy(angle * axis);
  return {q, box.centre() - q * box.centre() + 10 * voxel * share(random) * shift};
}

ProximityFigures Measure(SceneProximity& scene, std::size_t bodies, std::size_t part) {
  const ProximityShape& shape = scene.parts()[part].shape;
  const double voxel = shape.voxmap.voxel_size();
  const std::vector<std::array<float, 3>> points = PointsOn(shape.mesh);
  std::vector<float> distances(points.size());
  std::vector<Vec3> centres(kMostShadow);
  std::vector<Pose> X_W(bodies);
  std::mt19937_64 random(2);
  ProximityFigures f;
  for (int i = 0; i < kPoses; ++i) {
    X_W[scene.parts()[part].bodies.front()] =
        RandomDisplacement(random, shape.mesh.tree.nodes[0].box, voxel);
    f.colours.Add([&] {
      scene.Distances(part, points, X_W, distances);
    });
    for (const float d : distances) f.in_range += std::isfinite(d) ? 1 : 0;
    ShadowCount shadow;
    f.shadow.Add([&] {
      shadow = scene.Shadow(X_W, kShadowVoxels * voxel, centres);
    });
    f.most_shadow = std::max(f.most_shadow, shadow.found);
    SceneNearness near;
    f.coarse.Add([&] {
      near = scene.Nearest(X_W, {.refine = false});
    });
    f.refined.Add([&] {
      near = scene.Nearest(X_W);
    });
    f.unfinished += near.error_bound() > 2e-3 * voxel && !near.overlap ? 1 : 0;
  }
  return f;
}

int RunProximity(const ProximityArguments& arguments) {
  Result<Scene> scene = LoadNamedScene(arguments.scene.scene);
  if (!scene) return Fail(kExitFile, scene.error().what);
  if (arguments.scene.voxel_size > 0) scene->voxel_size = arguments.scene.voxel_size;
  std::vector<std::string> remarks;
  const Result<std::vector<ProximityBody>> bodies = LoadProximityBodies(*scene, &remarks);
  for (const std::string& remark : remarks) Say(remark);
  if (!bodies) return Fail(kExitFile, bodies.error().what);
  Result<std::vector<ProximityPart>> parts = MakeProximityParts(
      *bodies, scene->voxel_size, scene->range_voxels,
      [](std::size_t /*done*/, std::size_t /*total*/, const std::string& /*part*/) {
        return true;
      });
  if (!parts) return Fail(kExitFile, arguments.scene.scene + ": " + parts.error().what);
  SceneProximity proximity(std::make_shared<const std::vector<ProximityPart>>(std::move(*parts)));
  std::size_t part = 0;
  while (part < proximity.parts().size() && proximity.parts()[part].fixed) ++part;
  if (part == proximity.parts().size() || proximity.parts().size() < 2) {
    return Fail(kExitFile,
                arguments.scene.scene + ": the scene needs a moving body and another one");
  }
  const ProximityFigures f = Measure(proximity, bodies->size(), part);
  const double in_range = static_cast<double>(f.in_range) / (kPoses * kVertices);
  if (arguments.json) {
    const nlohmann::ordered_json out{{"scene", arguments.scene.scene},
                                     {"voxel_m", scene->voxel_size},
                                     {"poses", kPoses},
                                     {"vertices", kVertices},
                                     {"share_in_range", in_range},
                                     {"distances", f.colours.json()},
                                     {"shadow", f.shadow.json()},
                                     {"most_shadow_voxels", f.most_shadow},
                                     {"nearest_by_voxels", f.coarse.json()},
                                     {"nearest_by_triangles", f.refined.json()},
                                     {"searches_cut_short", f.unfinished}};
    std::printf("%s\n", JsonText(out, 2).c_str());
    return kExitOk;
  }
  std::printf("%d poses of %s, processor time of one thread, median and most\n", kPoses,
              proximity.parts()[part].name.c_str());
  const auto line = [](const char* what, const Times& times, const std::string& more) {
    std::printf("  %-21s %7.2f ms %7.2f ms  %s\n", what, times.median(), times.worst(),
                more.c_str());
  };
  line("distances", f.colours,
       std::to_string(kVertices) + " vertices, " + std::to_string(std::lround(100 * in_range)) +
           " % in range");
  line("shadow", f.shadow, "at most " + std::to_string(f.most_shadow) + " voxels");
  line("nearest, by voxels", f.coarse, "");
  line("nearest, by triangles", f.refined, std::to_string(f.unfinished) + " searches cut short");
  return kExitOk;
}

}  // namespace

void AddBenchProximity(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<ProximityArguments>();
  CLI::App* command = bench.add_subcommand("proximity",
                                           "Measure the time of distance queries beside the haptic "
                                           "loop: vertices' distances, shadow, nearest");
  AddBenchScene(*command, arguments->scene);
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunProximity(*arguments);
  });
}

}  // namespace tandem
