#pragma once

#include <cstddef>
#include <span>

#include "engine/base/spatial.h"
#include "engine/contact/body_features.h"
#include "engine/field/distance_field.h"

namespace tandem {

/// Voxels that a place may err by in single precision.
inline constexpr double kPlaceError = 2e-3;
/// Voxels of gap: what is farther apart is not told from what is this far.
inline constexpr double kEdgesEnough = 0.5;

/// A part of a sharp edge that may come to push against the edges of another body, V being the
/// frame of that body's field. Lengths in voxels.
struct EdgePart {
  std::size_t lane = 0;  // of its point in its block
  Vec3 middle_V = Vec3::Zero();
  Vec3 tangent_V = Vec3::Zero();
  double half_length = 0;
  double middle_bound = 0;  // the distance of the middle from the surface, at least
  double gap = 0;           // it pushes against no edge before both have come so much nearer
  bool outside = false;     // all of it is known to be outside of the other body
};

/// Finds the gaps that the distances of some places along each part tell. The surface may be
/// nearer to a part than to its middle by half its length, but is so only where they stand askew.
/// At most kBlockPlaces parts. Returns what that cost, in
/// look-ups.
std::size_t LookAlong(const DistanceField& field, double reach, std::span<EdgePart> parts) noexcept;

/// Finds the gaps that the other body's edges tell, for the parts with a gap of `enough` at most:
/// at most kBlockPlaces. Returns what that cost, in look-ups.
std::size_t LookAtOthers(const BodyFeatures& others, double reach, double enough,
                         std::span<EdgePart> parts) noexcept;

}  // namespace tandem
