#include "collab/energy_gate.h"

#include <algorithm>

#include "collab/planted_faults.h"

namespace tandem {

namespace {

/// Of the spring from the body to a copy, J.
double SpringEnergy(const Pose& y_WB, const RigidState& own, double k, const Mat3& per_mass) {
  const Vec3 theta = RotationVector(y_WB.q * own.X_WB.q.conjugate());
  return 0.5 * k * ((y_WB.p - own.X_WB.p).squaredNorm() + theta.dot(per_mass * theta));
}

}  // namespace

Pose EnergyGate::Admit(const Pose& y_WB, const RigidState& own, double stiffness,
                       const Mat3& per_mass) noexcept {
  clipped_ = false;
  if (!placed_) held_WB_ = y_WB;
  placed_ = true;
  const double before = SpringEnergy(held_WB_, own, stiffness, per_mass);
  const auto cost = [&](const Pose& y) {
    return SpringEnergy(y, own, stiffness, per_mass) - before;
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
    (cost(Between(held_WB_, y_WB, middle)) <= budget ? low : high) = middle;
  }
  const Pose reached = Between(held_WB_, y_WB, low);
  Add(-cost(reached));
  held_WB_ = reached;
  return held_WB_;
}

void EnergyGate::Add(double energy) noexcept {
  if (Planted(Fault::kGateForgets)) energy = std::max(0.0, energy);
  const double full = std::max(kCredit, tank_);
  tank_ += energy;
  if (tank_ <= full) return;
  overflow_ += tank_ - full;
  tank_ = full;
}

void EnergyGate::Earn(double dissipated) noexcept {
  Add(0.9 * std::max(0.0, dissipated));
}

void EnergyGate::Receive(double its_overflow) noexcept {
  // what it counted before we met is not ours
  if (told_ && its_overflow > received_) {
    tank_ = std::max(tank_, std::min(kMost, tank_ + (its_overflow - received_)));
  }
  received_ = told_ ? std::max(received_, its_overflow) : its_overflow;
  told_ = true;
}

}  // namespace tandem
