#pragma once

#include <vector>

#include "scenes/generated_scene.h"

namespace tandem {

/// A landing gear in its bay, as large as the paper's (4.1 x 1.9 x 4.8 m, section 7): a bogie with
/// six wheels, a strut that telescopes, torque links, braces and trunnions, doors with ribs and
/// bolts, hydraulic lines, wire bundles and equipment. Its retraction actuator lies in a nest
/// forward of the strut, under a keeper: a mechanic slides it back, lifts it, and takes it out
/// forward between two lines. z points up, x forward; the origin is the actuator's (mm).

/// All fixed parts, each by itself, where it stands.
std::vector<TriangleMesh> LandingGearParts();

/// The parts as one fixed mesh, `landing_gear_fixed.stl`, and the actuator,
/// `landing_gear_actuator.stl`, with the hand that takes it out.
GeneratedScene LandingGear(const std::vector<TriangleMesh>& parts);

}  // namespace tandem
