#pragma once

#include <cstdint>
#include <vector>

#include "engine/dynamics/rigid_body.h"

namespace tandem {

/// The linearly implicit step of bodies that push one another. If each body were solved alone, as
/// though the other stood, two bodies would exchange velocities whatever their masses. A light body
/// that hits a heavy one would gain energy. Solved together they keep their momentum, and energy
/// falls.
///
///   A_a V_a - (h D_ab + h^2 K_ab) V_b = b_a - h D_ab V0_b,  the same for b with D_ab, K_ab
///   transposed
///
/// Sized once; used by one thread; only the constructor allocates.
class CoupledStep {
 public:
  explicit CoupledStep(std::size_t bodies);

  /// Forgets all bodies.
  void Begin() noexcept;
  /// Adds a body's own equations, and the twists that it may have as columns of `basis`. Columns of
  /// zeros do no harm.
  void AddBody(std::size_t body, const StepEquations& step, const Twist& V0_WB,
               const Mat6& basis) noexcept;
  bool has(std::size_t body) const noexcept { return bodies_[body].here; }
  /// Adds the effect of two bodies on one another, after both have been added.
  void Couple(std::size_t a, std::size_t b, const CrossJacobian& cross, double h) noexcept;
  /// Solves for the twists at the end of the step. The symmetric part of the matrix is positive
  /// definite, so that blocks may be eliminated in any order.
  void Solve() noexcept;
  const Twist& twist(std::size_t body) const noexcept { return bodies_[body].V_WB; }

 private:
  struct Body {
    bool here = false;
    Mat6 basis;
    Vec6 V0;
    Vec6 rhs;
    Twist V_WB;
  };
  struct Block {
    bool filled = false;
    Mat6 value;
  };

  Block& block(std::size_t row, std::size_t column) noexcept {
    return blocks_[row * bodies_.size() + column];
  }
  /// Adds to a block, which counts as zero until it is filled.
  void Add(std::size_t row, std::size_t column, const Mat6& value) noexcept;

  std::vector<Body> bodies_;
  std::vector<Block> blocks_;
};

}  // namespace tandem
