#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "app/bench/fidelity/fidelity.h"
#include "app/bench/fidelity/tilted_plate.h"

namespace tandem {

namespace {

constexpr double kVoxel = kPlateVoxel;

/// Returns an attitude in which the body rests on the plate: the box on a face, the cylinder on an
/// end.
Quat RestingAttitude(const TiltedPlate& plate, Approaching body, std::mt19937_64& random) {
  if (body == Approaching::kSphere) return DrawnRotation(random);
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
      const Quat q_WB = DrawnRotation(random);
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
  constexpr int kSamples = 1000;      // samples of a slide
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
