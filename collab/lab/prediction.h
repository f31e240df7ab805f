#pragma once

#include <optional>

#include "collab/lab/exact_boundary.h"
#include "collab/lab/lab_case.h"

namespace tandem {

/// How stiff a case is, and how stiff it may be for all that theory knows (N/m, all links of a user
/// together; infinite when nothing is too stiff).
struct Prediction {
  double stiffness = 0;
  double critical = 0;

  /// So much below the boundary that it must be measured stable.
  bool is_stable() const { return stiffness < 0.9 * critical; }
};

/// The mean age of what a user applies of another, s: the way, half the jitter, half the time from
/// one sample that arrives to the next, and half a frame.
double MeanAge(const LabCase& test);

/// The case in translation, in free space, as an equation of one axis. Its gains are those of the
/// law at the loop age that the network gives; where hands differ, `user` says whose. Nothing where
/// no such equation holds: delays that a schedule changes, links that exchange forces.
std::optional<LumpedCoupling> LumpedOf(const LabCase& test, const Inertia& body, std::size_t user);

/// The least over the users. In scenes of contact, where the equation does not hold, the boundary
/// is that of what is passive whatever it touches: b/tau.
std::optional<Prediction> Predict(const LabCase& test, const Inertia& body);

}  // namespace tandem
