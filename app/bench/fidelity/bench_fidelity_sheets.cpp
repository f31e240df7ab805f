#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "app/bench/fidelity/factory_scene.h"
#include "app/bench/fidelity/fidelity.h"
#include "app/bench/fidelity/tilted_plate.h"
#include "engine/base/check.h"
#include "engine/world/world_of_meshes.h"
#include "scenes/generators/shapes.h"

namespace tandem {

namespace {

constexpr double kSheetVoxel = 0.0005;                    // m
constexpr std::array<double, 3> kMasses{0.05, 0.3, 2.0};  // kg
constexpr double kThickness = 0.3 * kSheetVoxel;          // thickness of the closed sheet
constexpr double kGoalSpeed = 5;                          // m/s
const Vec3 kBodySize(0.016, 0.012, 0.010);                // m

/// Returns a sheet round the origin across z, closed or open, and a box above it.
std::shared_ptr<const WorldModel> BoxOverSheet(bool open, double mass) {
  const Vec3 half(0.1, 0.1, 0.5 * kThickness);
  TriangleMesh sheet = Box(-half, half);
  if (open) {
    sheet.vertices = {{-half.x(), -half.y(), 0},
                      {half.x(), -half.y(), 0},
                      {half.x(), half.y(), 0},
                      {-half.x(), half.y(), 0}};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  }
  const Vec3 above(0, 0, 0.04);
  const auto made = WorldOfMeshes(
      {{.mesh_W = std::move(sheet), .fixed = true},
       {.mesh_W = Box(above - 0.5 * kBodySize, above + 0.5 * kBodySize), .mass = mass}},
      kSheetVoxel, ContactModel::kRefined);
  TANDEM_CHECK(made.has_value());
  return *made;
}

/// Draws a body's attitude and a direction that leads through the sheet. A hand's goal goes 80 mm
/// along it and waits there. Returns how far the body's centre comes beyond the sheet, m.
double DeepestBeyond(const std::shared_ptr<const WorldModel>& model, std::mt19937_64& random) {
  constexpr int kFrames = 300;
  constexpr double kWay = 0.08;  // m
  const Quat q = DrawnRotation(random);
  const Vec3 from(0, 0, Uniform(random, 0.014, 0.018));
  Vec3 way = DrawnRotation(random) * Vec3::UnitZ();
  way.z() = -std::abs(way.z()) - 0.3;
  way.normalize();
  TANDEM_CHECK((from + kWay * way).z() < 0);
  World world(model);
  world.Place(0, {q, from});
  StepInputs inputs = HandInputs(*model);
  double beyond = -from.z();
  for (int frame = 0; frame < kFrames; ++frame) {
    inputs.hand.goal.X_WA = {q, from + std::min(kWay, kGoalSpeed * kFrame * frame) * way};
    world.Step(inputs);
    beyond = std::max(beyond, -world.state(0).X_WB.p.z());
  }
  return beyond;
}

}  // namespace

SheetFigures MeasureSheets(int tries) {
  std::mt19937_64 random(41);
  SheetFigures figures;
  std::vector<std::shared_ptr<const WorldModel>> models;
  for (const bool open : {false, true}) {
    for (const double mass : kMasses) models.push_back(BoxOverSheet(open, mass));
  }
  for (; figures.tries < tries; ++figures.tries) {
    const auto& model = models[static_cast<std::size_t>(figures.tries) % models.size()];
    const double beyond = DeepestBeyond(model, random);
    figures.crossings += beyond > 0 ? 1 : 0;
    figures.nearest_voxels = std::min(figures.nearest_voxels, -beyond / kSheetVoxel);
  }
  return figures;
}

}  // namespace tandem
