#pragma once

#include <array>
#include <cstdint>

#include "scenes/generators/generated_scene.h"

namespace tandem {

/// A machine bay as large as a landing gear's, packed with machine parts, and an actuator in a nest
/// in its middle. The bay is a lattice of cells of about 0.3 m. Pipes and beams run through rows of
/// cells, and each other cell holds a part. So parts overlap only where a pipe's curve leaves its
/// cells. A corridor as long as the nest leads from it straight up and out.
struct ClutterShape {
  std::array<int, 3> cells = {14, 8, 15};  // along x, y, z; at least 6, 3 and 3
  double filled = 0.25;                    // share of the cells left by pipes and beams
  std::uint64_t seed = 20050318;
};

/// Returns all fixed parts, each separate, where it stands (mm).
std::vector<TriangleMesh> ClutterParts(const ClutterShape& shape);

struct ActuatorShape {
  double fineness = 1;  // number of sides of its round parts, as a share of the clutter's
  bool valves = false;  // it has a block of valves, with a port on either side
};

struct NestShape {
  double rear_stop = -500;  // x at which it begins, 25 mm thick
  /// It has no bolts on the walls, no guides above the actuator's axis, and hoses farther out.
  bool clear_walls = false;
};

/// Return the nest's fixed parts round the actuator, and the actuator, both about the origin (mm).
TriangleMesh ClutterNest(const NestShape& shape = {});
TriangleMesh ClutterActuator(const ActuatorShape& shape = {});

/// Returns the share of the parts' vertices that lie inside another part.
double OverlapShare(const std::vector<TriangleMesh>& parts);

double AreaOf(const TriangleMesh& mesh);

/// Prints the size of a scene of fixed parts and one actuator, and the share that overlaps.
void PrintSizes(const std::vector<TriangleMesh>& parts, const GeneratedScene& scene);

/// Makes the scene of the parts as one fixed mesh, `clutter_fixed.stl`, and the actuator,
/// `clutter_actuator.stl`, with its hand.
GeneratedScene Clutter(const std::vector<TriangleMesh>& parts);

}  // namespace tandem
