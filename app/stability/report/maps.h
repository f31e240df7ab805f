#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "app/stability/report/map_picture.h"
#include "collab/lab/case/lab_case.h"
#include "collab/lab/sweep/results_file.h"

namespace tandem {

/// Returns the shared body of a case's scene; nothing: the scene is not at hand.
using BodyOf = std::function<std::optional<Inertia>(const LabCase&)>;

/// Makes the maps of a sweep's cells, the map with most cells first. One kind of map has cells that
/// differ in delay and stiffness alone, the other in grasp and stiffness. A map is drawn if it has
/// several values of both.
std::vector<StabilityMap> MapsOf(const Results& results, const BodyOf& body_of);

/// Returns the lines of theory and of the laws for cases like this one, over a range of delays. The
/// exact boundary and the any-delay line are for free space alone. For contact theory gives only
/// the passive line.
std::vector<MapLine> LinesOf(const LabCase& like, const Inertia& body, double shortest_s,
                             double longest_s);

}  // namespace tandem
