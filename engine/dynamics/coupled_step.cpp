#include "engine/dynamics/coupled_step.h"

#include <Eigen/LU>

#include "engine/base/check.h"

namespace tandem {

CoupledStep::CoupledStep(std::size_t bodies) : bodies_(bodies), blocks_(bodies * bodies) {}

void CoupledStep::Begin() noexcept {
  for (Body& body : bodies_) body.here = false;
  for (Block& block : blocks_) block.filled = false;
}

void CoupledStep::Add(std::size_t row, std::size_t column, const Mat6& value) noexcept {
  Block& to = block(row, column);
  if (to.filled) {
    to.value += value;
  } else {
    to.value = value;
  }
  to.filled = true;
}

void CoupledStep::AddBody(std::size_t number, const StepEquations& step, const Twist& V0_WB,
                          const Mat6& basis) noexcept {
  Body& body = bodies_[number];
  body.here = true;
  body.basis = basis;
  body.V0 = Stacked(V0_WB);
  body.rhs = basis.transpose() * step.b;
  Mat6 reduced = basis.transpose() * step.A * basis;
  for (Eigen::Index k = 0; k < 6; ++k) {
    if (basis.col(k).isZero(0)) reduced(k, k) = 1.0;  // an unknown that stays 0
  }
  Add(number, number, reduced);
}

void CoupledStep::Couple(std::size_t a, std::size_t b, const CrossJacobian& cross,
                         double h) noexcept {
  TANDEM_CHECK(has(a) && has(b));
  Body& first = bodies_[a];
  Body& second = bodies_[b];
  const Mat6 change = h * cross.damping + h * h * cross.stiffness;
  Add(a, b, -first.basis.transpose() * change * second.basis);
  Add(b, a, -second.basis.transpose() * change.transpose() * first.basis);
  first.rhs -= h * (first.basis.transpose() * (cross.damping * second.V0));
  second.rhs -= h * (second.basis.transpose() * (cross.damping.transpose() * first.V0));
}

void CoupledStep::Solve() noexcept {
  const std::size_t n = bodies_.size();
  for (std::size_t k = 0; k < n; ++k) {
    if (!has(k)) continue;
    const Eigen::PartialPivLU<Mat6> pivot(block(k, k).value);
    bodies_[k].rhs = pivot.solve(bodies_[k].rhs).eval();
    for (std::size_t j = k + 1; j < n; ++j) {
      if (block(k, j).filled) block(k, j).value = pivot.solve(block(k, j).value).eval();
    }
    for (std::size_t i = k + 1; i < n; ++i) {
      if (!block(i, k).filled) continue;
      const Mat6 factor = block(i, k).value;
      bodies_[i].rhs -= factor * bodies_[k].rhs;
      for (std::size_t j = k + 1; j < n; ++j) {
        if (block(k, j).filled) Add(i, j, -factor * block(k, j).value);
      }
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    if (!has(k)) continue;
    Body& body = bodies_[k];
    for (std::size_t j = k + 1; j < n; ++j) {
      if (block(k, j).filled) body.rhs -= block(k, j).value * bodies_[j].rhs;
    }
    const Vec6 V = body.basis * body.rhs;
    body.V_WB = {V.head<3>(), V.tail<3>()};
  }
}

}  // namespace tandem
