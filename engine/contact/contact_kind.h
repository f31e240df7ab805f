#pragma once

#include <cstdint>

namespace tandem {

/// How the points in contact become forces.
enum class ContactModel : std::uint8_t {
  kPlain,   // paper §2.1: the tangent plane through the voxel's middle
  kRefined  // exact features against exact features (decision 0010)
};

/// Queues between the deepest force layer and the range of the distance field.
inline constexpr int kWarningQueues = 2;

/// The force layer that a model needs (paper §3.2): of the plain one, 2 is the least that never
/// lets exact surfaces meet; the refined one looks at what lies in the first.
constexpr int DefaultForceLayer(ContactModel model) {
  return model == ContactModel::kPlain ? 2 : 1;
}

/// Of feature polygons, voxels either side of their plane (paper §4.1).
constexpr double FlatnessVoxels(ContactModel model) {
  return model == ContactModel::kPlain ? 0.5 : 0.25;
}

}  // namespace tandem
