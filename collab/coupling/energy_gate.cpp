#include "collab/coupling/energy_gate.h"

#include <algorithm>

namespace tandem {

EnergyGate::Stretch EnergyGate::StretchOf(const Pose& y_WB, const RigidState& own,
                                          const Mat3& per_mass) noexcept {
  const Vec3 turn = RotationVector(y_WB.q * own.X_WB.q.conjugate());
  return {turn, (y_WB.p - own.X_WB.p).squaredNorm() + turn.dot(per_mass * turn)};
}

Pose EnergyGate::Modulate(const Pose& y_WB, const RigidState& own, double stiffness,
                          const Mat3& per_mass) noexcept {
  clipped_ = false;
  if (!placed_) held_WB_ = y_WB;
  placed_ = true;
  const auto energy = [stiffness](const Stretch& stretch) {
    return 0.5 * stiffness * stretch.square;
  };
  const double before = energy(StretchOf(held_WB_, own, per_mass));
  const auto cost = [&](const Pose& y) {
    stretch_ = StretchOf(y, own, per_mass);
    return energy(stretch_) - before;
  };
  const double all = cost(y_WB);
  if (all <= 0 || all <= tank_) {
    held_WB_ = y_WB;
    Add(-all);
    return held_WB_;
  }
  clipped_ = true;
  const double budget = std::max(0.0, tank_);
  double low = 0;
  double high = 1;
  for (int i = 0; i < 20; ++i) {
    const double middle = 0.5 * (low + high);
    (cost(Interpolate(held_WB_, y_WB, middle)) <= budget ? low : high) = middle;
  }
  const Pose reached = Interpolate(held_WB_, y_WB, low);
  Add(-cost(reached));
  held_WB_ = reached;
  return held_WB_;
}

void EnergyGate::Add(double energy) noexcept {
  const double full = std::max(kCredit, tank_);
  tank_ += energy;
  if (tank_ <= full) return;
  overflow_ += tank_ - full;
  tank_ = full;
}

void EnergyGate::Credit(double dissipated) noexcept {
  Add(0.9 * std::max(0.0, dissipated));
}

void EnergyGate::Receive(double its_overflow) noexcept {
  // energy counted before the link began is not ours
  if (reported_ && its_overflow > received_) {
    tank_ = std::max(tank_, std::min(kMost, tank_ + (its_overflow - received_)));
  }
  received_ = reported_ ? std::max(received_, its_overflow) : its_overflow;
  reported_ = true;
}

}  // namespace tandem
