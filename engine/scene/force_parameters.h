#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/scene/scene.h"

namespace tandem {

/// The parameters of a scene that decide how hard contact pushes, apart from the bodies. Peers that
/// differ in them can still meet, but push one another unequally (paper §6.1; decision 0022).
struct ForceParameters {
  double voxel_size = 0.001;  // m
  ContactModel contact = ContactModel::kRefined;
  int force_layer = 1;
  double friction = 0;
  double stiffness = 50e3;  // N/m at a point of a light body (LeastContactStiffness)

  friend bool operator==(const ForceParameters&, const ForceParameters&) = default;
};

ForceParameters ParametersOf(const Scene& scene);
/// Sets the parameters of a scene, and the range that its force layer needs. The scene cannot
/// choose the stiffness: it follows from the voxels.
void Adopt(const ForceParameters& parameters, Scene& scene);
std::uint64_t HashOf(const ForceParameters& parameters);
/// Returns a text such as "voxels of 1 mm, refined contact, force layer 1, friction 0".
std::string Describe(const ForceParameters& parameters);

/// Returns the gap between flat faces at which contact begins, m. With exact features it is a part
/// of a voxel. With voxels alone it is the force layer for faces along the axes, and half as much
/// farther for others.
double GapAtFirstForce(const ForceParameters& parameters);

/// The forces between two bodies when each user simulates their own body with other parameters.
struct UnequalPush {
  /// The first user pushes harder; false: the second.
  bool first_harder = false;
  /// The pushed user feels contact from this far before the other does, m.
  double head_start = 0;
  /// Force at each point in contact, N, up to which the pushed user has all the force and the other
  /// none; 0 where contact begins at the same gap for both.
  double alone_force = 0;
  /// Ratio of the force on the pushed user to that on the other, where contact begins at the same
  /// gap.
  double ratio = 1;
};

/// Compares two parameters. Hands yield far sooner than contact does. So the user with the larger
/// voxels, whose contact begins at the wider gap, stands off there and has all of the force. The
/// user with the smaller voxels pushes harder (paper §6.1). If contact begins at the same gap, the
/// body with the stiffer contact is pushed back harder, by the ratio of stiffnesses. `mass` (kg):
/// of the heavier body. Returns nothing where both push alike, as when only friction differs.
std::optional<UnequalPush> ComparePush(const ForceParameters& first, const ForceParameters& second,
                                       double mass);

}  // namespace tandem
