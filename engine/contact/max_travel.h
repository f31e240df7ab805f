#pragma once

#include <algorithm>
#include <limits>

namespace tandem {

/// What the next frame's tests will cost one pair, or several together (paper §5, Eqn. 2).
struct TestLoad {
  double mandatory = 0;  // point tests owed in every frame
  double per_metre = 0;  // point tests owed for each metre of travel: sum of n_i / a_i
  /// The farthest that the pair's two bodies may come towards one another in a frame, m.
  double bound = std::numeric_limits<double>::infinity();

  TestLoad& operator+=(const TestLoad& other) {
    mandatory += other.mandatory;
    per_metre += other.per_metre;
    bound = std::min(bound, other.bound);
    return *this;
  }
};

/// Of a voxel: never less may be moved in a frame, however many tests are owed. At zero a part in
/// heavy contact could not be pulled out again (VPS.md §5.6).
inline constexpr double kTravelFloor = 0.02;

/// How far all pairs may go in the coming frame, in metres, so that the tests it makes due fit into
/// `capacity` point tests: paper §5, Eqn. 2 with allowances (i - 1) s in place of 0.5 s i. Frames
/// are of constant length, so this is a speed limit, which the hand feels as viscosity. Each pair's
/// own bound comes on top; never below the floor.
inline double MaxTravel(const TestLoad& load, double capacity, double voxel_size) {
  const double spare = capacity - load.mandatory;
  double travel = load.bound;
  if (load.per_metre > 0) travel = std::min(travel, spare / load.per_metre);
  if (spare <= 0) travel = 0;
  return std::max(travel, kTravelFloor * voxel_size);
}

}  // namespace tandem
