#include "engine/contact/field/fit_reach.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace tandem {

namespace {

/// Share of the overlap of opposite sides by which the reach shrinks in a frame. If it were much
/// larger, contacts that bear a load in a tight fit would lose it for a frame.
constexpr double kReachCut = 0.25;
/// Voxels by which the reach grows in a frame without overlap.
constexpr double kReachPace = 0.01;
/// Voxels of overlap from which on the reach does not grow.
constexpr double kNoRoom = 0.005;
/// Directions all round, one for each pair of opposite directions. No direction is farther than 28
/// degrees from the nearest of these or their opposites.
constexpr double kEdgeWay = 0.70710678118654752;
constexpr double kCornerWay = 0.57735026918962576;
constexpr std::size_t kDirections = 13;
constexpr double kE = kEdgeWay;
constexpr double kC = kCornerWay;
constexpr std::array<double, kDirections> kWaysX{1, 0, 0, kE, kE, kE, kE, 0, 0, kC, kC, kC, kC};
constexpr std::array<double, kDirections> kWaysY{0, 1, 0, kE, -kE, 0, 0, kE, kE, kC, kC, -kC, -kC};
constexpr std::array<double, kDirections> kWaysZ{0, 0, 1, 0, 0, kE, -kE, kE, -kE, kC, -kC, kC, -kC};
/// Cosines of the angle with a direction: up to kAlong a push counts in full along it, from kAside
/// on it does not count.
constexpr double kAlong = 0.88;
constexpr double kAside = 0.7;

}  // namespace

double FittedReach(std::span<const Contact> contacts, double voxel_size, double reach,
                   double full_reach) noexcept {
  // by direction: the deepest contact that pushes along it, weighted by how far it does
  std::array<double, kDirections> forth{};
  std::array<double, kDirections> back{};
  constexpr double kPerCosine = 1.0 / (kAlong - kAside);
  for (const Contact& contact : contacts) {
    const Vec3& nhat = contact.nhat_V;
    const double deep = contact.depth * contact.share;
    for (std::size_t i = 0; i < kDirections; ++i) {
      const double along = nhat.x() * kWaysX[i] + nhat.y() * kWaysY[i] + nhat.z() * kWaysZ[i];
      const auto counts = [](double cosine) {
        return std::min(1.0, std::max(0.0, (cosine - kAside) * kPerCosine));
      };
      forth[i] = std::max(forth[i], deep * counts(along));
      back[i] = std::max(back[i], deep * counts(-along));
    }
  }
  double common = 0;  // m
  for (std::size_t i = 0; i < kDirections; ++i) {
    common = std::max(common, std::min(forth[i], back[i]));
  }
  const double overlap = common / voxel_size;
  // squared, the growth changes little where both balance: otherwise the overlap would never settle
  const double room = std::max(0.0, 1.0 - overlap / kNoRoom);
  const double wider = kReachPace * room * room;
  const double least_reach = std::min(kLeastReach, full_reach);
  return std::clamp(reach - kReachCut * overlap + wider, least_reach, full_reach);
}

}  // namespace tandem
