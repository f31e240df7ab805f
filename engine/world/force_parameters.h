#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/world/scene.h"

namespace tandem {

/// What of a scene says how hard contact pushes, apart from what the bodies are. Peers that differ
/// in it can still meet, but push one another unequally (paper §6.1; decision 0022).
struct ForceParameters {
  double voxel_size = 0.001;  // m
  ContactModel contact = ContactModel::kRefined;
  int force_layer = 1;
  double friction = 0;
  double stiffness = 50e3;  // N/m at a point of a light body (LeastContactStiffness)

  friend bool operator==(const ForceParameters&, const ForceParameters&) = default;
};

ForceParameters ParametersOf(const Scene& scene);
/// Gives them to a scene, and the range that its force layer needs. The stiffness is not the
/// scene's to choose: it follows from the voxels.
void Adopt(const ForceParameters& parameters, Scene& scene);
std::uint64_t HashOf(const ForceParameters& parameters);
/// "voxels of 1 mm, refined contact, force layer 1, friction 0"
std::string Describe(const ForceParameters& parameters);

/// The gap between flat faces at which contact begins, m: a part of a voxel with exact features;
/// with voxels alone the force layer (of faces along the axes; others half as much farther).
double GapAtFirstForce(const ForceParameters& parameters);

/// How two bodies press one another when each user simulates their own by other parameters.
struct UnequalPush {
  /// Which of the two pushes harder; false: the other one.
  bool first_harder = false;
  /// The one who is pushed feels contact from so far before the other does, m.
  double head_start = 0;
  /// N at each point in contact up to which the pushed one has all the force and the other none;
  /// 0 where both begin at one gap.
  double alone_force = 0;
  /// Force on the pushed one to that on the other where both begin at one gap.
  double ratio = 1;
};

/// Hands yield far sooner than contact does, so whose contact begins at the wider gap, with the
/// larger voxels, stands off there and has all of the force: the user with the smaller voxels
/// pushes harder (paper §6.1). Where both begin at one gap, the body of the stiffer contact is
/// pushed back harder, by the ratio of stiffnesses. `mass` (kg): of the heavier body. Nothing where
/// both push alike, as with other friction alone.
std::optional<UnequalPush> ComparePush(const ForceParameters& first, const ForceParameters& second,
                                       double mass);

}  // namespace tandem
