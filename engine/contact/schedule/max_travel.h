#pragma once

#include <algorithm>
#include <limits>

namespace tandem {

/// The cost of the next frame's tests of one pair, or of several together (paper §5, Eqn. 2).
struct TestDemand {
  double mandatory = 0;      // point tests owed in every frame
  double per_metre = 0;      // point tests owed for each metre of travel: sum of n_i / a_i
  double exact_queries = 0;  // exact queries at what may be in contact, whatever the travel
  /// The farthest that the pair's two bodies may come towards one another in a frame, m.
  double bound = std::numeric_limits<double>::infinity();

  TestDemand& operator+=(const TestDemand& other) {
    mandatory += other.mandatory;
    per_metre += other.per_metre;
    exact_queries += other.exact_queries;
    bound = std::min(bound, other.bound);
    return *this;
  }
};

/// The least travel that is always allowed in a frame, voxels, however many tests are owed. At zero
/// a part in heavy contact could not be pulled out again (decision 0014).
inline constexpr double kTravelFloor = 0.02;
/// The share of the point tests that fit into a frame beside the mandatory ones that travel may
/// always use. Slowing further would not make a frame of many queries shorter, and the hand would
/// feel viscosity for nothing.
inline constexpr double kTravelShare = 0.4;

/// Returns how far all pairs may go in the coming frame, m, so that the tests that it makes due fit
/// into `capacity` point tests. This is paper §5, Eqn. 2, with allowances (i - 1) s in place of
/// 0.5 s i. Each exact query at what may be in contact counts as `query_price` tests. Frames have
/// constant length, so this is a speed limit, which the hand feels as viscosity. Each pair's own
/// bound applies too; the result is never below the floor.
inline double MaxTravel(const TestDemand& demand, double capacity, double query_price,
                        double voxel_size) {
  const double room = capacity - demand.mandatory;
  if (room <= 0) return kTravelFloor * voxel_size;
  const double spare = std::max(room - query_price * demand.exact_queries, kTravelShare * room);
  const double travel =
      demand.per_metre > 0 ? spare / demand.per_metre : std::numeric_limits<double>::infinity();
  return std::max(std::min(travel, demand.bound), kTravelFloor * voxel_size);
}

}  // namespace tandem
