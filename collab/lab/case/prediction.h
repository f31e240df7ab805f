#pragma once

#include <cstdint>
#include <optional>

#include "collab/lab/case/lab_case.h"
#include "collab/lab/theory/exact_boundary.h"
#include "collab/lab/theory/grasp_boundary.h"

namespace tandem {

/// The stiffness of a case, and the critical stiffness that theory gives for it (N/m, all links of
/// a user together; infinite when nothing is too stiff).
struct Prediction {
  double stiffness = 0;
  double critical = 0;
  /// The motion for which `critical` is the boundary.
  enum class Covers : std::uint8_t {
    kMotion,     // every free motion, travel and turning together, about every user's grasp
    kPassivity,  // passivity, whatever the body touches, with any mass and grasp
  };
  Covers covers = Covers::kMotion;

  /// Returns whether the stiffness is far enough below the boundary that the case must be measured
  /// stable.
  bool is_stable() const { return stiffness < 0.9 * critical; }
};

/// Returns "six axes" or "passivity".
const char* NameOf(Prediction::Covers covers);

/// Returns the mean age of the data that a user applies from another user, s. It is the sum of the
/// delay, the mean wait that jitter causes where samples keep their order, the mean age in the gaps
/// between arriving samples, and half a frame.
double MeanAge(const LabCase& test);

/// Returns the case's translation in free space as an equation of one axis, with the hand of
/// `user`. The gains are those of the law at the loop age that the network gives. Nothing where no
/// such equation holds: a schedule changes the delays, or links exchange forces.
std::optional<LumpedCoupling> LumpedOf(const LabCase& test, const Inertia& body, std::size_t user);

/// Returns the same in all six axes, with each user's own hand and grasp. Nothing where LumpedOf()
/// gives nothing.
std::optional<GraspCoupling> GraspCouplingOf(const LabCase& test, const Inertia& body);

/// Predicts whether the case is stable. In free space the boundary is exact. It comes from
/// LumpedOf() where all users hold the body alike and at its centre, because rotation then behaves
/// as travel does. Else it comes from GraspCouplingOf(). In scenes with contact neither holds, and
/// the boundary is that of passivity: b/tau, the least over the users.
std::optional<Prediction> Predict(const LabCase& test, const Inertia& body);

}  // namespace tandem
