#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "app/cli/bench_fidelity.h"
#include "engine/base/check.h"
#include "engine/contact/contact_pair.h"
#include "engine/voxel/voxelize.h"
#include "scenes/shapes.h"

namespace tandem {

namespace {

constexpr double kVoxel = 0.001;  // m; every figure is in voxels

Quat RandomRotation(std::mt19937_64& random) {
  // uniform: Shoemake's three numbers
  const double u = Uniform(random, 0, 1);
  const double a = Uniform(random, 0, 2 * std::numbers::pi);
  const double b = Uniform(random, 0, 2 * std::numbers::pi);
  return Quat(std::sqrt(1 - u) * std::sin(a), std::sqrt(1 - u) * std::cos(a),
              std::sqrt(u) * std::sin(b), std::sqrt(u) * std::cos(b));
}

/// The bodies are convex, so their exact gap to a plane is a vertex's.
TriangleMesh MeshOf(Approaching body) {
  switch (body) {
    case Approaching::kSphere:
      return OctahedralSphere(10 * kVoxel, 4, false);
    case Approaching::kBox:
      return Box(kVoxel * Vec3(-12, -9, -7), kVoxel * Vec3(12, 9, 7));
    case Approaching::kCylinder:
      return Revolved({{8 * kVoxel, -12 * kVoxel}, {8 * kVoxel, 12 * kVoxel}}, 64);
  }
  return {};
}

BodySurface SurfaceOf(const TriangleMesh& mesh_W, const Pose& X_WB) {
  Scene scene;
  scene.voxel_size = kVoxel;
  Result<BodySurface> made = MakeSurface(scene, mesh_W, X_WB);
  TANDEM_CHECK(made.has_value());
  return std::move(*made);
}

/// A plate whose upper face is a tilted plane, as a voxmap body.
struct TiltedPlate {
  TiltedPlate(ContactModel contact, std::mt19937_64& random) : q(RandomRotation(random)) {
    normal = q * Vec3::UnitZ();
    for (int i = 0; i < 3; ++i) place[i] = Uniform(random, 0, kVoxel);
    const TriangleMesh mesh_W =
        Transformed(Box(kVoxel * Vec3(-90, -90, -14), kVoxel * Vec3(90, 90, 0)), {q, place});
    if (contact == ContactModel::kRefined) {
      surface = SurfaceOf(mesh_W, Pose{});
      surface.radius = 0;
      return;
    }
    const double flatness = FlatnessVoxels(contact);
    Result<Voxmap> made = Voxelize(mesh_W, {.voxel_size = kVoxel, .flatness_voxels = flatness});
    TANDEM_CHECK(made.has_value());
    voxmap = std::move(*made);
  }

  Quat q;
  Vec3 normal;
  Vec3 place;  // on the face, m
  Voxmap voxmap;
  BodySurface surface;  // in its place, in the refined model
};

/// A body over a plate, its points made at a random attitude to the grid.
struct Pressing {
  Pressing(ContactModel contact, Approaching body, const TiltedPlate& on, std::mt19937_64& random)
      : plate(on), mesh_B(MeshOf(body)) {
    const Pose X_WB{RandomRotation(random), Vec3::Zero()};
    const ContactGains gains{1.0 / kVoxel, 0};
    if (contact == ContactModel::kRefined) {
      surface = SurfaceOf(Transformed(mesh_B, X_WB), X_WB);
      pair = std::make_unique<FieldPair>(surface, plate.surface, FieldPair::Options{}, gains);
      return;
    }
    Result<Pointshell> made =
        MakePointshell(Transformed(mesh_B, X_WB), X_WB,
                       {.spacing = kVoxel, .flatness_voxels = FlatnessVoxels(contact)});
    TANDEM_CHECK(made.has_value());
    shell = std::move(*made);
    pair = std::make_unique<ContactPair>(
        shell, plate.voxmap, Pose{Quat::Identity(), plate.voxmap.p_WVo()}, 0.0,
        PairOptions{.force_layer = DefaultForceLayer(contact), .schedule = {}}, gains);
  }

  /// The lowest vertex above the face, m, of the body at that attitude with its origin on it.
  double Lowest(const Quat& q_WB) const {
    double lowest = std::numeric_limits<double>::max();
    for (const Vec3& v : mesh_B.vertices) lowest = std::min(lowest, plate.normal.dot(q_WB * v));
    return lowest;
  }
  /// The body's pose with that exact gap (m), beside the face's middle by `along`.
  Pose At(const Quat& q_WB, const Vec3& along, double gap) const {
    return {q_WB, plate.place + along + (gap - Lowest(q_WB)) * plate.normal};
  }
  Vec3 ForceAt(const Pose& X_WB) {
    Load on_shell;
    Load on_map;
    pair->Collide({X_WB, {}}, {}, on_shell, on_map);
    return AsWrench(on_shell.force).f;
  }
  /// Voxels, over the contacts of the last force.
  double MeanDepth() const {
    double sum = 0;
    for (const Contact& contact : pair->contacts()) sum += contact.depth;
    return pair->contacts().empty() ? 0.0
                                    : sum / kVoxel / static_cast<double>(pair->contacts().size());
  }

  const TiltedPlate& plate;
  TriangleMesh mesh_B;
  Pointshell shell;
  BodySurface surface;  // in its place, in the refined model
  std::unique_ptr<BodyPair> pair;
};

/// An attitude in which the body rests on the plate: the box on a face, the cylinder on an end.
Quat RestingAttitude(const TiltedPlate& plate, Approaching body, std::mt19937_64& random) {
  if (body == Approaching::kSphere) return RandomRotation(random);
  return plate.q * RotationBy(Vec3(0, 0, Uniform(random, 0, 2 * std::numbers::pi)));
}

}  // namespace

Spread MeasureFirstForce(ContactModel contact, Approaching body, int tilts, int approaches) {
  constexpr double kStep = 0.02;  // voxels
  std::mt19937_64 random(11 + static_cast<std::uint64_t>(body));
  Spread gaps{std::numeric_limits<double>::max(), 0, -std::numeric_limits<double>::max()};
  int done = 0;
  for (int tilt = 0; tilt < tilts; ++tilt) {
    const TiltedPlate plate(contact, random);
    Pressing pressing(contact, body, plate, random);
    for (; done < approaches * (tilt + 1) / tilts; ++done) {
      const Quat q_WB = RandomRotation(random);
      const Vec3 side(Uniform(random, -40, 40), Uniform(random, -40, 40), 0);
      const Vec3 along = plate.q * (kVoxel * side);
      double gap = 7.0;
      while (gap > -3.0 &&
             !(pressing.ForceAt(pressing.At(q_WB, along, gap * kVoxel)).dot(plate.normal) > 0)) {
        gap -= kStep;
      }
      gaps.min = std::min(gaps.min, gap);
      gaps.max = std::max(gaps.max, gap);
      gaps.mean += gap / approaches;
    }
  }
  return gaps;
}

PressedFigures MeasurePressed(ContactModel contact, int tilts) {
  constexpr int kSamples = 1000;      // of a slide
  constexpr double kSlide = 100;      // voxels
  constexpr double kMeanDepth = 0.5;  // voxels
  std::mt19937_64 random(12);
  PressedFigures figures;
  double ripple_squares = 0;
  for (int tilt = 0; tilt < tilts; ++tilt) {
    const TiltedPlate plate(contact, random);
    const auto body = static_cast<Approaching>(tilt % 3);
    Pressing pressing(contact, body, plate, random);
    const Quat q_WB = RestingAttitude(plate, body, random);
    const double heading = Uniform(random, 0, 2 * std::numbers::pi);
    const Vec3 way = plate.q * Vec3(std::cos(heading), std::sin(heading), 0);
    const Vec3 beside = plate.q * Vec3(-std::sin(heading), std::cos(heading), 0);
    const Vec3 start =
        kVoxel * (Uniform(random, -10, 10) * beside + Uniform(random, -60, -40) * way);
    double gap = 7.0;
    while (gap > -6.0 && pressing.MeanDepth() < kMeanDepth) {
      gap -= 0.005;
      pressing.ForceAt(pressing.At(q_WB, start, gap * kVoxel));
    }
    double sum = 0;
    double squares = 0;
    double worst = 0;
    double errors = 0;
    for (int i = 0; i < kSamples; ++i) {
      const Vec3 along = start + (kSlide * kVoxel * i / kSamples) * way;
      const Vec3 force = pressing.ForceAt(pressing.At(q_WB, along, gap * kVoxel));
      const double pressed = force.norm();
      sum += pressed;
      squares += pressed * pressed;
      const double error = std::atan2(force.cross(plate.normal).norm(), force.dot(plate.normal)) *
                           180 / std::numbers::pi;
      errors += error;
      worst = std::max(worst, error);
    }
    const double mean = sum / kSamples;
    const double ripple = std::sqrt(std::max(0.0, squares / kSamples - mean * mean)) / mean;
    figures.direction_error_mean += errors / kSamples / tilts;
    figures.direction_error_max = std::max(figures.direction_error_max, worst);
    ripple_squares += ripple * ripple / tilts;
    figures.ripple_max = std::max(figures.ripple_max, ripple);
  }
  figures.ripple = std::sqrt(ripple_squares);
  return figures;
}

}  // namespace tandem
