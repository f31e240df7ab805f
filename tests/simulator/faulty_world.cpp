#include "tests/simulator/faulty_world.h"

#include <limits>

namespace tandem {

void ShowNoNumber(World& world, const std::function<void()>& look) {
  const Pose X_WB = world.state(0).X_WB;
  world.Place(0, {X_WB.q, Vec3::Constant(std::numeric_limits<double>::quiet_NaN())});
  look();
  world.Place(0, X_WB);
}

}  // namespace tandem
