#pragma once

#include <cstddef>
#include <span>

#include "engine/base/spatial.h"
#include "engine/contact/features/body_features.h"
#include "engine/field/query/distance_field.h"

namespace tandem {

/// The greatest error of a place in single precision, voxels.
inline constexpr double kPlaceError = 2e-3;
/// The gap beyond which gaps are not told apart, voxels.
inline constexpr double kEdgesEnough = 0.5;

/// A part of a sharp edge that may come to push against the edges of another body. V is the frame
/// of that body's field. Lengths are in voxels.
struct EdgePart {
  std::size_t lane = 0;  // lane of its point in its block
  Vec3 middle_V = Vec3::Zero();
  Vec3 tangent_V = Vec3::Zero();
  double half_length = 0;
  double middle_bound = 0;  // lower bound of the distance of the middle from the surface
  double gap = 0;           // travel towards each other before which it pushes against no edge
  bool outside = false;     // all of the part is known to be outside of the other body
};

/// Finds the gaps that follow from the distances of some places along each part. The surface may be
/// nearer to a part than to its middle by half the part's length, but is so only where they stand
/// askew. Takes at most kBlockPlaces parts. Returns the cost in look-ups.
std::size_t QueryAlong(const DistanceField& field, double reach,
                       std::span<EdgePart> parts) noexcept;

/// Finds the gaps that follow from the other body's edges, for the parts whose gap is at most
/// `enough`. Takes at most kBlockPlaces parts. Returns the cost in look-ups.
std::size_t QueryOtherEdges(const BodyFeatures& others, double reach, double enough,
                            std::span<EdgePart> parts) noexcept;

}  // namespace tandem
