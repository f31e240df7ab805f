#include "engine/contact/clear_region.h"

#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

/// A point mostly slides along what it is near: way along a surface is used up sooner than way
/// towards it.
constexpr double kWorth = 0.2;
/// Voxels: planes whose margins are this near the least have a say in the region's normal.
constexpr double kNearLeast = 0.15;
/// Voxels: more than what single precision rounds.
constexpr double kRounding = 1e-5;

}  // namespace

double ClearRegion::Room(const Vec3& p, double now, double turn, double turns) const noexcept {
  const Vec3 way = p - from;
  const double gone = way.norm();
  const double by = now - turned;
  const double left = margin + way.dot(normal.cast<double>()) - spread * gone - swing * by;
  return std::min({reach - gone, left / (1.0 + spread + swing * turns), (turn - by) / turns});
}

void ClearRegionMaker::KeepAbove(const Vec3& normal, double margin, double swing,
                                 double way) noexcept {
  if (way >= reach_) return;
  if (margin > kLeast && margin > kWorth * way && count_ < halves_.size()) {
    halves_[count_++] = {normal, margin, swing};
  } else {
    reach_ = way;
  }
}

ClearRegion ClearRegionMaker::Make(const Vec3& p, double turned,
                                   std::uint32_t point) const noexcept {
  ClearRegion region;
  region.from = p;
  region.turned = turned;
  region.point = point;
  region.reach = static_cast<float>(reach_ - kRounding);
  region.margin = 2 * static_cast<float>(kReach);
  if (count_ == 0) return region;
  const auto halves = halves_.begin();
  const auto end = halves + static_cast<std::ptrdiff_t>(count_);
  double least = halves->margin;
  for (auto half = halves; half != end; ++half) least = std::min(least, half->margin);
  Vec3 sum = Vec3::Zero();
  for (auto half = halves; half != end; ++half) {
    sum += std::max(0.0, least + kNearLeast - half->margin) * half->normal;
  }
  const double length = sum.norm();
  if (!(length > kRounding)) {  // between what faces one another
    double swing = 0;
    for (auto half = halves; half != end; ++half) swing = std::max(swing, half->swing);
    region.reach = static_cast<float>(std::min(reach_, 0.5 * least) - kRounding);
    region.margin = static_cast<float>(0.5 * least);
    region.swing = static_cast<float>(swing * (1 + kRounding));
    return region;
  }
  const Vec3 normal = sum / length;
  // a plane of another normal, or that swings more, is left behind by what it has more of margin
  double spread = 0;
  double swing = 0;
  for (auto half = halves; half != end; ++half) {
    const double more = half->margin - least;
    const double apart = (half->normal - normal).norm();
    const double for_spread = std::min(more, apart * reach_);
    spread = std::max(spread, apart - for_spread / reach_);
    swing = std::max(swing, half->swing - (more - for_spread) / turn_);
  }
  region.normal = normal.cast<float>();
  region.margin = static_cast<float>(least - kRounding);
  region.spread = static_cast<float>(spread + kRounding);
  region.swing = static_cast<float>(swing * (1 + kRounding));
  return region;
}

}  // namespace tandem
