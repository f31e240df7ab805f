#pragma once

#include <cstdint>
#include <optional>

#include "collab/lab/exact_boundary.h"
#include "collab/lab/grasp_boundary.h"
#include "collab/lab/lab_case.h"

namespace tandem {

/// How stiff a case is, and how stiff it may be for all that theory knows (N/m, all links of a user
/// together; infinite when nothing is too stiff).
struct Prediction {
  double stiffness = 0;
  double critical = 0;
  /// What `critical` is the boundary of.
  enum class Covers : std::uint8_t {
    kMotion,     // every free motion, travel and turning together, about every user's grasp
    kPassivity,  // what is passive whatever it touches, with any mass and grasp
  };
  Covers covers = Covers::kMotion;

  /// So much below the boundary that it must be measured stable.
  bool is_stable() const { return stiffness < 0.9 * critical; }
};

/// "six axes" or "passivity".
const char* NameOf(Prediction::Covers covers);

/// The mean age of what a user applies of another, s: the way, half the jitter, half the time from
/// one sample that arrives to the next, and half a frame.
double MeanAge(const LabCase& test);

/// The case in translation, in free space, as an equation of one axis. Its gains are those of the
/// law at the loop age that the network gives; where hands differ, `user` says whose. Nothing where
/// no such equation holds: delays that a schedule changes, links that exchange forces.
std::optional<LumpedCoupling> LumpedOf(const LabCase& test, const Inertia& body, std::size_t user);

/// The same in all six axes, each user with the hand and grasp of its own. Nothing where LumpedOf()
/// gives nothing.
std::optional<GraspCoupling> GraspCouplingOf(const LabCase& test, const Inertia& body);

/// Exact in free space: by LumpedOf() where all hold the body alike and at its centre, for turning
/// goes as travel does then, else by GraspCouplingOf(). In scenes of contact, where neither holds,
/// the boundary is that of what is passive whatever it touches: b/tau, the least over the users.
std::optional<Prediction> Predict(const LabCase& test, const Inertia& body);

}  // namespace tandem
