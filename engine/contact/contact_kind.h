#pragma once

#include <cstdint>
#include <string>

namespace tandem {

/// How the points in contact become forces.
enum class ContactModel : std::uint8_t {
  kPlain,   // paper §2.1: the tangent plane through the voxel's middle
  kRefined  // exact features against exact features (decision 0010)
};

/// Queues between the deepest force layer and the range of the distance field.
inline constexpr int kWarningQueues = 2;

/// Where a scene says nothing, distances are exact so many voxels from surfaces in refined contact,
/// and force may be let begin so many voxels off.
inline constexpr double kDefaultFineBand = 0.65;
inline constexpr double kDefaultClearanceRange = 1.5;

/// The force layer that a model needs (paper §3.2): of the plain one, 2 is the least that never
/// lets exact surfaces meet; the refined one looks at what lies in the first.
constexpr int DefaultForceLayer(ContactModel model) {
  return model == ContactModel::kPlain ? 2 : 1;
}

/// The least force layer in which a model finds all the contacts that it makes. Refined contacts
/// begin kRefinedClearance from exact features, which may lie in the next voxel: layer 0 holds only
/// some of them, and every layer from 1 on the same ones. Plain contacts are those of the layer,
/// whichever it is.
constexpr int LeastForceLayer(ContactModel model) {
  return model == ContactModel::kPlain ? 0 : 1;
}

/// Why a model cannot work with a force layer, and which layer works; empty if it can.
inline std::string LayerFault(ContactModel model, int layer) {
  if (layer >= LeastForceLayer(model)) return {};
  return "refined contact misses contacts at force layer " + std::to_string(layer) + ": layer " +
         std::to_string(LeastForceLayer(model)) + " finds them all (plain contact works with 0)";
}

/// Of feature polygons, voxels either side of their plane (paper §4.1).
constexpr double FlatnessVoxels(ContactModel model) {
  return model == ContactModel::kPlain ? 0.5 : 0.25;
}

}  // namespace tandem
