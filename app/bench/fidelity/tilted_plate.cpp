#include "app/bench/fidelity/tilted_plate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "engine/base/check.h"
#include "engine/contact/pair/contact_pair.h"
#include "engine/voxel/build/voxelize.h"
#include "scenes/generators/shapes.h"

namespace tandem {

namespace {

TriangleMesh MeshOf(Approaching body) {
  switch (body) {
    case Approaching::kSphere:
      return OctahedralSphere(10 * kPlateVoxel, 4, false);
    case Approaching::kBox:
      return Box(kPlateVoxel * Vec3(-12, -9, -7), kPlateVoxel * Vec3(12, 9, 7));
    case Approaching::kCylinder:
      return Revolved({{8 * kPlateVoxel, -12 * kPlateVoxel}, {8 * kPlateVoxel, 12 * kPlateVoxel}},
                      64);
  }
  return {};
}

BodySurface SurfaceOf(const TriangleMesh& mesh_W, const Pose& X_WB, double clearance_range) {
  Scene scene;
  scene.voxel_size = kPlateVoxel;
  scene.clearance_range_voxels = clearance_range;
  Result<BodySurface> made = MakeSurface(scene, mesh_W, X_WB);
  TANDEM_CHECK(made.has_value());
  return std::move(*made);
}

/// Returns the height of a body's lowest vertex along a normal, from the body's origin, m.
double Lowest(const TriangleMesh& mesh_B, const Quat& q_WB, const Vec3& normal_W) {
  double lowest = std::numeric_limits<double>::max();
  for (const Vec3& v : mesh_B.vertices) lowest = std::min(lowest, normal_W.dot(q_WB * v));
  return lowest;
}

}  // namespace

Quat DrawnRotation(std::mt19937_64& random) {
  // Shoemake's method
  const double u = Uniform(random, 0, 1);
  const double a = Uniform(random, 0, 2 * std::numbers::pi);
  const double b = Uniform(random, 0, 2 * std::numbers::pi);
  return Quat(std::sqrt(1 - u) * std::sin(a), std::sqrt(1 - u) * std::cos(a),
              std::sqrt(u) * std::sin(b), std::sqrt(u) * std::cos(b));
}

TiltedPlate::TiltedPlate(ContactModel contact, std::mt19937_64& random, double range_voxels)
    : q(DrawnRotation(random)), clearance_range(range_voxels) {
  normal = q * Vec3::UnitZ();
  for (int i = 0; i < 3; ++i) place[i] = Uniform(random, 0, kPlateVoxel);
  const TriangleMesh mesh_W = Transformed(
      Box(kPlateVoxel * Vec3(-90, -90, -14), kPlateVoxel * Vec3(90, 90, 0)), {q, place});
  if (contact == ContactModel::kRefined) {
    surface = SurfaceOf(mesh_W, Pose{}, clearance_range);
    surface.radius = 0;
    return;
  }
  const double flatness = FlatnessVoxels(contact);
  Result<Voxmap> made = Voxelize(mesh_W, {.voxel_size = kPlateVoxel, .flatness_voxels = flatness});
  TANDEM_CHECK(made.has_value());
  voxmap = std::move(*made);
}

Pressing::Pressing(ContactModel contact, Approaching body, const TiltedPlate& on,
                   std::mt19937_64& random)
    : plate(on), mesh_B(MeshOf(body)) {
  const Pose X_WB{DrawnRotation(random), Vec3::Zero()};
  const ContactGains gains{1.0 / kPlateVoxel, 0};
  if (contact == ContactModel::kRefined) {
    surface = SurfaceOf(Transformed(mesh_B, X_WB), X_WB, plate.clearance_range);
    pair = std::make_unique<FieldPair>(surface, plate.surface, FieldPair::Options{}, gains);
    return;
  }
  Result<Pointshell> made =
      MakePointshell(Transformed(mesh_B, X_WB), X_WB,
                     {.spacing = kPlateVoxel, .flatness_voxels = FlatnessVoxels(contact)});
  TANDEM_CHECK(made.has_value());
  shell = std::move(*made);
  pair = std::make_unique<ContactPair>(
      shell, plate.voxmap, Pose{Quat::Identity(), plate.voxmap.p_WVo()}, 0.0,
      PairOptions{.force_layer = DefaultForceLayer(contact), .schedule = {}}, gains);
}

Pose Pressing::At(const Quat& q_WB, const Vec3& along, double gap) const {
  const double height = gap - Lowest(mesh_B, q_WB, plate.normal);
  return {q_WB, plate.place + along + height * plate.normal};
}

Vec3 Pressing::ForceAt(const Pose& X_WB) {
  LinearizedForce on_shell;
  LinearizedForce on_map;
  pair->Collide({X_WB, {}}, {}, on_shell, on_map);
  return AsWrench(on_shell.force).f;
}

double Pressing::MeanDepth() const {
  double sum = 0;
  for (const Contact& contact : pair->contacts()) sum += contact.depth;
  return pair->contacts().empty()
             ? 0.0
             : sum / kPlateVoxel / static_cast<double>(pair->contacts().size());
}

}  // namespace tandem
