#include "collab/lab/run/bisection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collab/lab/case/prediction.h"

namespace tandem {

namespace {

constexpr double kStep = 1.25;    // factor between steps of the search for growth
constexpr double kNear = 1.005;   // ratio of the two ends at which the bisection stops
constexpr double kLeast = 0.125;  // lowest stiffness tried, as a share of the predicted boundary

/// Returns a run long enough to tell growth of a few thousandths a second from slow decay. At a
/// delay of 1 s with light hands, motion a tenth beyond the boundary grows no faster.
double SecondsFor(const LabCase& test) {
  return std::max(60.0, 300.0 * test.delay_s);
}

/// Returns the coupling of the user with the lowest boundary.
std::optional<LumpedCoupling> WeakestOf(const LabCase& test, const Inertia& body) {
  std::optional<LumpedCoupling> weakest;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t user = 0; user < test.users; ++user) {
    const std::optional<LumpedCoupling> lumped = LumpedOf(test, body, user);
    if (!lumped) return std::nullopt;
    const double critical = CriticalStiffness(*lumped);
    if (weakest && critical >= least) continue;
    least = critical;
    weakest = lumped;
  }
  return weakest;
}

}  // namespace

BoundaryPoint FindBoundary(LabCase test, const LabScene& scene, double most) {
  BoundaryPoint point;
  test.law.ratio = 1;
  const std::optional<LumpedCoupling> lumped = WeakestOf(test, scene.inertia());
  if (!lumped || !(lumped->stiffness > 0)) {
    point.fault = Error{
        "no boundary is known of a case whose delays change, that exchanges forces"
        " or has no stiffness"};
    return point;
  }
  point.predicted = CriticalStiffness(*lumped);
  if (!std::isfinite(point.predicted)) {
    point.fault = Error{"theory knows of no stiffness that would be too much"};
    return point;
  }
  LumpedCoupling at_onset = *lumped;
  at_onset.stiffness = point.predicted;
  point.onset_hz = RightmostRoot(at_onset).imag() / (2.0 * M_PI);

  if (test.seconds == 0) test.seconds = SecondsFor(test);
  const auto grows = [&](double ratio) {
    test.law.ratio = ratio * point.predicted / lumped->stiffness;
    const CaseResult result = RunCase(test, scene);
    ++point.runs;
    if (result.fault && !point.fault) point.fault = result.fault;
    // motion that has grown into a limit grows no more, and is faster than any knock made it
    return result.metrics.diverged || result.metrics.growth > 0 || result.metrics.tail_rms > 1;
  };
  double dies = 1;
  double lives = 1;
  if (grows(1)) {
    do {
      lives = dies;
      dies /= kStep;
    } while (!point.fault && dies > kLeast && grows(dies));
  } else {
    do {
      dies = lives;
      lives *= kStep;
    } while (!point.fault && lives <= most && !grows(lives));
    if (lives > most) dies = lives = std::numeric_limits<double>::infinity();
  }
  while (!point.fault && lives > kNear * dies) {
    const double middle = std::sqrt(dies * lives);
    (grows(middle) ? lives : dies) = middle;
  }
  point.measured = std::sqrt(dies) * std::sqrt(lives) * point.predicted;
  return point;
}

}  // namespace tandem
