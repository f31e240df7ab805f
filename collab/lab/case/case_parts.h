#pragma once

#include <memory>

#include "collab/lab/case/lab_case.h"

namespace tandem {

/// The parts of a case for one user, the same for peers in virtual time and for live peers. Users
/// are counted from 0.

/// Returns the case for that body. Each hand that is not from a file gets the rotational impedance
/// of Turning(). A share of the boundary becomes a stiffness, at most that share of 10 kN/m.
LabCase FittedTo(const Inertia& body, LabCase test);

/// Returns the user's hand with its grasp: the hand's own, a hand file's or the scene's. The
/// scene's grasp is the centre of mass, and in off_centre a point 54 mm beside it. A hand without a
/// spring gets 300 N/m where it moves and 400 N/m where it holds still.
HandScript ScriptOf(const LabCase& test, std::size_t user);
/// Returns when the last push or waypoint of any hand is over, s from the hands' start.
double LastInputEnds(const LabCase& test);

/// Returns the conditions on the way from one user to another, at a one-way delay of the case.
LinkConditions ConditionsOf(const LabCase& test, std::size_t from, std::size_t to, double delay_s);
/// Returns the longest delay of any sample of the case, jitter included, s.
double LongestDelay(const LabCase& test);

/// Returns the law's limits with the case's ratio.
CouplingLimits LimitsOf(const LabLaw& law);
/// Returns the law with its stiffness times the case's ratio; its drags are those for ratio 1.
/// Error: there is no law of that name.
Result<std::shared_ptr<const CouplingLaw>> LawOf(const LabLaw& law);

}  // namespace tandem
