#include "app/bench/measure/bench_scene.h"

#include <algorithm>
#include <cmath>

#include "app/common/console.h"
#include "app/common/option_checks.h"
#include "app/common/program_cache.h"
#include "app/common/scene_files.h"
#include "app/judgement/start_gaps.h"

namespace tandem {

void AddBenchScene(CLI::App& command, BenchScene& scene) {
  command.add_option("--scene", scene.scene, "name of a scene, or a scene file")
      ->capture_default_str();
  command.add_option("--voxel", scene.voxel_size, "voxel size, m; default: the scene's")
      ->check(NumberFrom(kLeastVoxel, kLargestVoxel));
}

namespace {

/// Fixes all bodies but the first hand's for this run if the scene fixes none.
void HoldTheOthers(Scene& scene) {
  const auto fixed = [](const SceneBody& body) {
    return body.fixed;
  };
  if (std::ranges::any_of(scene.bodies, fixed) || scene.bodies.size() < 2) return;
  const int named = scene.hands.empty() ? 0 : scene.BodyNamed(scene.hands[0].body);
  const std::size_t moving = scene.WholeOf(static_cast<std::size_t>(std::max(0, named)));
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    scene.bodies[i].fixed = scene.WholeOf(i) != moving;
  }
  Say(scene.file.string() + ": the scene has no fixed body: all bodies but " +
      scene.bodies[moving].name + " are held in place for this");
}

/// Makes the first body's pointshell anew, with about `wanted` points.
std::optional<Error> SetPoints(std::size_t wanted, WorldModel& world) {
  BodyModel& body = world.bodies[0];
  const TriangleMesh& mesh_W = world.meshes_W[world.object[0]];
  Scene scene = world.scene;
  for (int attempt = 0; attempt < 3; ++attempt) {
    const double ratio = static_cast<double>(body.points.size()) / static_cast<double>(wanted);
    if (std::abs(ratio - 1) < 0.01) break;
    scene.voxel_size *= std::sqrt(ratio);  // their number goes with the area
    Result<Pointshell> points = MakePoints(scene, mesh_W, body.X_WB0, 0);
    if (!points) return points.error();
    body.points = std::move(*points);
  }
  return std::nullopt;
}

}  // namespace

Result<std::shared_ptr<const WorldModel>> LoadBenchScene(const BenchScene& requested) {
  Result<Scene> scene = LoadNamedScene(requested.scene);
  if (!scene) return scene.error();
  if (requested.needs_fixture) HoldTheOthers(*scene);
  if (requested.voxel_size > 0) scene->voxel_size = requested.voxel_size;
  auto world = LoadAndTell(*scene);
  if (world) TellStart(FindStartGaps(**world));
  const bool plain = scene->contact == ContactModel::kPlain;
  const bool sets_points = requested.points > 0 && (plain || requested.needs_plain_parts);
  if (requested.points > 0 && !sets_points) {
    Say(requested.scene + ": its contact tests features, not points, so --points changes nothing");
  }
  if (!world || (!sets_points && (plain || !requested.needs_plain_parts))) return world;
  auto changed = std::make_shared<WorldModel>(**world);
  if (!plain) {
    if (const auto fault = AddPlainParts(*changed)) return *fault;
  }
  if (sets_points) {
    if (const auto fault = SetPoints(requested.points, *changed)) return *fault;
  }
  return std::shared_ptr<const WorldModel>(std::move(changed));
}

}  // namespace tandem
