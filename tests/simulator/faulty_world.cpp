#include "tests/simulator/faulty_world.h"

#include <limits>

#include "tests/simulator/injected_faults.h"

namespace tandem {

namespace {

void Shift(std::size_t body, double metres, World& world) noexcept {
  const Pose& X_WB = world.state(body).X_WB;
  world.Place(body, {X_WB.q, X_WB.p + Vec3(metres, 0, 0)});
}

}  // namespace

void ShowNoNumber(World& world, const std::function<void()>& look) {
  const Pose X_WB = world.state(0).X_WB;
  world.Place(0, {X_WB.q, Vec3::Constant(std::numeric_limits<double>::quiet_NaN())});
  look();
  world.Place(0, X_WB);
}

void ShiftBodies(std::uint32_t seq, int held, const StepInputs& inputs, World& world) noexcept {
  if (Injected(Fault::kHeldSlips) && held >= 0 && seq % 1000 == 999) {
    Shift(static_cast<std::size_t>(held), 3e-3, world);
  }
  if (!Injected(Fault::kMirrorTrembles)) return;
  for (std::size_t b = 0; b < world.model().bodies.size(); ++b) {
    if (inputs.instances[b].drive != BodyDrive::kMirrored) continue;
    Shift(b, seq % 2 == 0 ? 2e-3 : -2e-3, world);
  }
}

}  // namespace tandem
