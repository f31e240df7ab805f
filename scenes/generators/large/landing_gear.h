#pragma once

#include <vector>

#include "scenes/generators/generated_scene.h"

namespace tandem {

/// A landing gear in its bay, as large as the paper's (4.1 x 1.9 x 4.8 m, section 7): a bogie with
/// six wheels, a strut that telescopes, torque links, braces and trunnions, doors with ribs and
/// bolts, hydraulic lines, wire bundles and equipment. Its retraction actuator lies in a nest
/// forward of the strut. A keeper holds its rod's eye down, and two hooks the ports of its valves.
/// A mechanic lifts it off its racks, slides it back until it is free of them, raises it, and takes
/// it out forward between two lines. z points up, x forward; the origin is the actuator's (mm).

enum class LandingGearParts {
  kAll,
  kNest  // the parts that the actuator meets on its way out: its nest, and the two lines
};

/// Returns the fixed parts, each separate, where it stands.
std::vector<TriangleMesh> MakeLandingGear(LandingGearParts parts);

/// Makes the scene of the parts as one fixed mesh, `landing_gear_fixed.stl`, and the actuator,
/// `landing_gear_actuator.stl`. Two hands take it out. A third, `landing_gear_hasty.json`, lifts it
/// without sliding it back first.
GeneratedScene LandingGear(const std::vector<TriangleMesh>& parts);

}  // namespace tandem
