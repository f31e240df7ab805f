// Forces that derive from a potential do no work on a body that comes back to where it was. Contact
// without friction and damping is to be near to that: what it gives in each round shakes a part
// that is pressed and held loosely.
#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "engine/contact/field/field_pair.h"
#include "tests/engine/contact/refined.h"

namespace tandem {
namespace {

using testing::HollowBlock;
using testing::kS;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Refined;
using testing::Sphere;

constexpr double kPressed = 0.4;  // N
constexpr double kLoop = 0.01;    // voxels, the radius of the loop along the surface

/// Returns where the body stands in that direction from the middle when it is pushed by kPressed.
Vec3 PressedPlace(Refined& met, const Quat& q_WB, const Vec3& direction) {
  double free = 0;
  double deep = 4 * kS;
  for (int halving = 0; halving < 40; ++halving) {
    const double middle = 0.5 * (free + deep);
    const bool less = met.FirstForceAt({q_WB, middle * direction}).norm() < kPressed;
    (less ? free : deep) = middle;
  }
  return free * direction;
}

/// Returns the work on the body round an ellipse, as a share of kPressed over the ellipse's length.
/// Its long axis lies along the surface, its short one, a tenth of that, along the force.
double ShareOfWork(Refined& met, const Pose& X_WB, const Vec3& along, const Vec3& normal) {
  constexpr int kSteps = 200;
  constexpr double kLong = kLoop * kS;
  const auto place = [&](int step) -> Vec3 {
    const double angle = 2.0 * M_PI * step / kSteps;
    return X_WB.p + kLong * (std::cos(angle) * along + 0.1 * std::sin(angle) * normal);
  };
  double work = 0;
  Vec3 before = met.FirstForceAt({X_WB.q, place(0)});
  for (int step = 1; step <= kSteps; ++step) {
    const Vec3 force = met.FirstForceAt({X_WB.q, place(step)});
    work += 0.5 * (before + force).dot(place(step) - place(step - 1));
    before = force;
  }
  return std::abs(work) / (kPressed * 4 * kLong);
}

TEST(ContactWork, ClosedLoopInAFacetedCupDoesAlmostNoWork) {
  Refined met(HollowBlock(26 * kS, 9 * kS), Sphere(8 * kS, 3), Quat::Identity());
  std::mt19937_64 random(5);
  double worst = 0;
  double sum = 0;
  constexpr int kPlaces = 60;
  for (int i = 0; i < kPlaces; ++i) {
    const Quat q_WB = RandomRotation(random);
    const Vec3 direction = RandomDirection(random);
    const Pose X_WB{q_WB, PressedPlace(met, q_WB, direction)};
    for (const Vec3& along :
         {direction.unitOrthogonal(), Vec3(direction.cross(direction.unitOrthogonal()))}) {
      const double share = ShareOfWork(met, X_WB, along, direction);
      worst = std::max(worst, share);
      sum += share;
    }
  }
  EXPECT_LT(worst, 5e-4);
  EXPECT_LT(sum / (2 * kPlaces), 6e-5);
}

}  // namespace
}  // namespace tandem
