#pragma once

#include <memory>

#include "collab/lab/lab_case.h"

namespace tandem {

/// What a case comes to for one user: the same for peers in virtual time and for live ones. Users
/// are counted from 0.

/// The case for that body: each hand but one of a file turns as it travels, its inertia over its
/// mass being the body's, and a share of the boundary has become a stiffness, at most 10 kN/m.
LabCase FittedTo(const Inertia& body, LabCase test);

/// The user's hand, with its grasp: its own, a hand file's or the scene's, which is the centre of
/// mass but in off_centre, 54 mm beside it. One that is to move, or to hold still, and has no
/// spring gets one: 300 N/m, 400 N/m.
HandScript ScriptOf(const LabCase& test, std::size_t user);
/// When the last push or waypoint of any hand is over, s from the hands' start.
double LastInputEnds(const LabCase& test);

/// What lies on the way from one user to another, at a one-way delay of the case.
LinkConditions ConditionsOf(const LabCase& test, std::size_t from, std::size_t to, double delay_s);
/// The longest delay, jitter included, that any sample of the case is held back for, s.
double LongestDelay(const LabCase& test);

/// The law's limits, the case's ratio among them.
CouplingLimits LimitsOf(const LabLaw& law);
/// The law times the case's ratio: its stiffness alone, its drags are those for 1. Error: there is
/// none of that name.
Result<std::shared_ptr<const CouplingLaw>> LawOf(const LabLaw& law);

}  // namespace tandem
