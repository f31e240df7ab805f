#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "collab/coupling_law.h"
#include "collab/lab/exact_boundary.h"

namespace tandem {
namespace {

constexpr double kHeaviest = 1.5;  // kg, what the laws are made for

/// All instances alike under the law made for te, the copies `delay_s` old.
LumpedCoupling Under(const CouplingLaw& law, double te, double delay_s, double mass,
                     std::size_t users) {
  const LawInputs at = LawInputsAt((2.0 * te - 0.005) / 1.1, users, kHeaviest);
  const LinkLaw link = law.Link(at);
  const double links = static_cast<double>(users - 1);
  return {.mass = mass,
          .damping = law.GroundDamping(at, links * link.stiffness),
          .stiffness = links * link.stiffness,
          .relative_damping = links * link.relative_damping,
          .delay_s = delay_s,
          .users = users};
}

class EveryLaw : public ::testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Laws, EveryLaw, ::testing::Values("p+d", "p+dd"),
                         [](const ::testing::TestParamInfo<const char*>& tested) {
                           return std::string(tested.param) == "p+d" ? "OneDamping" : "TwoDampings";
                         });

// Hands off or firm, light or heavy, two to eight users, at every delay up to that which the law is
// made for, without any drag but the law's own.
TEST_P(EveryLaw, IsStableAtEveryDelayUpToItsOwn) {
  const auto law = *MakeLaw(GetParam());
  for (const std::size_t users : {2U, 3U, 8U}) {
    for (double te = 0.004; te < 1.3; te *= 1.15) {
      for (const double share : {0.05, 0.3, 0.6, 1.0}) {
        for (const double mass : {0.3, 0.5, 1.0, kHeaviest}) {
          for (const double hand : {0.0, 100.0, 800.0}) {
            LumpedCoupling model = Under(*law, te, share * te, mass, users);
            model.hand_stiffness = hand;
            EXPECT_TRUE(IsStable(model)) << users << " users, te " << te << ", share " << share
                                         << ", " << mass << " kg, hand " << hand;
          }
        }
      }
    }
  }
}

// Margins, hands off, of the heaviest, without any drag but the law's own: p+d has none below 0.1
// s.
TEST(TwoDampings, BearAQuarterMoreDelayAndAFifthMoreStiffness) {
  const auto law = *MakeLaw("p+dd");
  for (double te = 0.004; te < 1.3; te *= 1.15) {
    EXPECT_TRUE(IsStable(Under(*law, te, 1.25 * te, kHeaviest, 2))) << te;
    LumpedCoupling firmer = Under(*law, te, te, kHeaviest, 2);
    firmer.stiffness *= 1.2;
    EXPECT_TRUE(IsStable(firmer)) << te;
  }
}

// The proof for a constant delay: passive while k te <= 2 B, beyond below what is stable at any
// delay. Somewhere in between both hold.
TEST(TwoDampings, ArePassiveOrStableAtAnyDelay) {
  const auto law = *MakeLaw("p+dd");
  bool both = false;
  for (double te = 0.004; te < 2.0; te *= 1.05) {
    const LumpedCoupling model = Under(*law, te, te, kHeaviest, 2);
    const double k_te = model.stiffness * te;
    const double injection = PassiveInjection(model.relative_damping / k_te);
    const bool passive = model.damping >= 1.2 * injection * k_te;
    const double any = AnyDelayStiffness(model.damping, kHeaviest, model.relative_damping);
    const bool at_any_delay = model.stiffness <= any;
    EXPECT_TRUE(passive || at_any_delay) << te;
    both = both || (passive && at_any_delay);
  }
  EXPECT_TRUE(both);
}

}  // namespace
}  // namespace tandem
