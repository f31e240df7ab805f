#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/contact/features/body_features.h"
#include "engine/geometry/mesh/round_surfaces.h"

namespace tandem {

/// The balls and cylinders of a body, and which of its feature points lie on them. A round surface
/// touches where it faces what it touches. Its features are only places of its mesh, which come and
/// go as it rolls. Lengths are in voxels, places in the frame V of the body's field.
struct RoundFeatures {
  static constexpr std::uint8_t kNone = 255;
  static constexpr std::size_t kMostRounds = 32;

  struct Round {
    RoundSurface surface;
    Vec3 side = Vec3::Zero();  // unit, across a cylinder's axis
    /// The height of the cap about the place that faces the other body, in which a feature lies
    /// however the body turns, and a margin.
    double cap = 0;
  };
  std::vector<Round> rounds;
  std::vector<std::uint8_t> of_point;  // per lane of each block: its round, or kNone
  double most_cap = 0;

  bool empty() const noexcept { return rounds.empty(); }
  std::uint8_t RoundOf(std::size_t block, std::size_t lane) const noexcept {
    return rounds.empty() ? kNone : of_point[BodyFeatures::kLanes * block + lane];
  }
};

/// Finds the round surfaces of a body's mesh that bulge. `p_WVo` is the field's origin in W, m.
RoundFeatures FindRoundFeatures(const TriangleMesh& mesh_W, const Vec3& p_WVo, double voxel_size,
                                const BodyFeatures& features);

}  // namespace tandem
