#pragma once

#include <cstdint>
#include <string>

namespace tandem {

/// The model by which points in contact become forces.
enum class ContactModel : std::uint8_t {
  kPlain,   // paper §2.1: the tangent plane through the voxel's middle
  kRefined  // exact features against exact features (decision 0010)
};

/// The number of queues between the deepest force layer and the range of the distance field.
inline constexpr int kWarningQueues = 2;

/// Defaults of a scene in refined contact, voxels: distances are exact in the fine band, and force
/// can begin up to the clearance range from surfaces.
inline constexpr double kDefaultFineBand = 0.65;
inline constexpr double kDefaultClearanceRange = 1.5;

/// Returns the force layer that a model needs (paper §3.2). In the plain model 2 is the least layer
/// that never lets exact surfaces meet. The refined model looks at what lies in the first.
constexpr int DefaultForceLayer(ContactModel model) {
  return model == ContactModel::kPlain ? 2 : 1;
}

/// Returns the least force layer in which a model finds all its contacts. Refined contacts begin
/// kRefinedClearance from exact features, which may lie in the next voxel. So layer 0 holds only
/// some of them, and every layer from 1 on all of them. Plain contacts are those of the layer,
/// whichever it is.
constexpr int LeastForceLayer(ContactModel model) {
  return model == ContactModel::kPlain ? 0 : 1;
}

/// Returns why a model cannot work with a force layer, and which layer works; empty if it can.
inline std::string LayerFault(ContactModel model, int layer) {
  if (layer >= LeastForceLayer(model)) return {};
  return "refined contact misses contacts at force layer " + std::to_string(layer) + ": layer " +
         std::to_string(LeastForceLayer(model)) + " finds them all (plain contact works with 0)";
}

/// Returns the flatness of feature polygons: voxels either side of their plane (paper §4.1).
constexpr double FlatnessVoxels(ContactModel model) {
  return model == ContactModel::kPlain ? 0.5 : 0.25;
}

}  // namespace tandem
