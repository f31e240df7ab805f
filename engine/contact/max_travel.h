#pragma once

#include <algorithm>
#include <limits>

namespace tandem {

/// What the next frame's tests will cost one pair, or several together (paper §5, Eqn. 2).
struct TestLoad {
  double mandatory = 0;  // point tests owed in every frame
  double per_metre = 0;  // point tests owed for each metre of travel: sum of n_i / a_i
  double looks = 0;      // exact looks owed in every frame (LookLoad)
  double looks_per_metre = 0;
  double most_looks = 0;  // that travel is known to make due: beyond, it makes no more
  /// The farthest that the pair's two bodies may come towards one another in a frame, m.
  double bound = std::numeric_limits<double>::infinity();

  TestLoad& operator+=(const TestLoad& other) {
    mandatory += other.mandatory;
    per_metre += other.per_metre;
    looks += other.looks;
    looks_per_metre += other.looks_per_metre;
    most_looks += other.most_looks;
    bound = std::min(bound, other.bound);
    return *this;
  }
};

/// Of a voxel: never less may be moved in a frame, however many tests are owed. At zero a part in
/// heavy contact could not be pulled out again (decision 0014).
inline constexpr double kTravelFloor = 0.02;

/// How far all pairs may go in the coming frame, in metres, so that what it makes due fits into
/// `capacity` point tests: paper §5, Eqn. 2 with allowances (i - 1) s in place of 0.5 s i, and with
/// the exact look at what may be in contact as so many more tests, `look_price` each. Frames are of
/// constant length, so this is a speed limit, which the hand feels as viscosity. Each pair's own
/// bound comes on top; never below the floor.
inline double MaxTravel(const TestLoad& load, double capacity, double look_price,
                        double voxel_size) {
  const double spare = capacity - load.mandatory - look_price * load.looks;
  if (spare <= 0) return kTravelFloor * voxel_size;
  const auto until = [](double left, double per_metre) {
    return per_metre > 0 ? left / per_metre : std::numeric_limits<double>::infinity();
  };
  double travel = until(spare, load.per_metre + look_price * load.looks_per_metre);
  const double left = spare - look_price * load.most_looks;
  if (left > 0) travel = std::max(travel, until(left, load.per_metre));
  return std::max(std::min(travel, load.bound), kTravelFloor * voxel_size);
}

}  // namespace tandem
