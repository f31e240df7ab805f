#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "app/stability/map_picture.h"
#include "collab/lab/lab_case.h"
#include "collab/lab/results_file.h"

namespace tandem {

/// The shared body of a case's scene; nothing where the scene is not at hand.
using BodyOf = std::function<std::optional<Inertia>(const LabCase&)>;

/// The maps that a sweep's cells make: cells that differ in delay and stiffness
/// alone are on one map, which is drawn if they have several of each; so are cells that differ in
/// grasp and stiffness. The one with most cells comes first.
std::vector<StabilityMap> MapsOf(const Results& results, const BodyOf& body_of);

/// What theory and the laws say for cases like this one at every delay from one
/// to another: the exact boundary and the any-delay line in free space alone,
/// for contact only what is passive.
std::vector<MapLine> LinesOf(const LabCase& like, const Inertia& body, double shortest_s,
                             double longest_s);

}  // namespace tandem
