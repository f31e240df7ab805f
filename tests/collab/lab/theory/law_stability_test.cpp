#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "collab/coupling/coupling_law.h"
#include "collab/lab/theory/exact_boundary.h"
#include "collab/lab/theory/grasp_boundary.h"

namespace tandem {
namespace {

constexpr double kHeaviest = 1.5;  // kg, what the laws are made for

/// Returns instances that are all alike under the law made for te, with copies `delay_s` old.
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

// Hands are off or firm, light or heavy, of two to eight users, at every delay up to that for which
// the law is made. There is no drag but the law's own.
TEST_P(EveryLaw, IsStableUpToItsStatedDelay) {
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

// Margins are with hands off, of the heaviest instance, without any drag but the law's own. p+d has
// none below 0.1 s.
TEST(TwoDampings, GainAQuarterInDelayAndAFifthInStiffness) {
  const auto law = *MakeLaw("p+dd");
  for (double te = 0.004; te < 1.3; te *= 1.15) {
    EXPECT_TRUE(IsStable(Under(*law, te, 1.25 * te, kHeaviest, 2))) << te;
    LumpedCoupling firmer = Under(*law, te, te, kHeaviest, 2);
    firmer.stiffness *= 1.2;
    EXPECT_TRUE(IsStable(firmer)) << te;
  }
}

// A link with bc = r k tau against the ground drag g(r) k tau is passive at a constant delay,
// whatever it is between (docs/stability.md, 9.6). No mass, hand, grasp or contact is too much.
TEST(TwoDampings, ArePassiveAtEveryDelayForAnyMass) {
  const auto law = *MakeLaw("p+dd");
  for (const std::size_t users : {2U, 3U, 8U}) {
    for (double te = 0.003; te < 10; te *= 1.3) {
      const LawInputs at = LawInputsAt((2.0 * te - 0.005) / 1.1, users, kHeaviest);
      const LinkLaw link = law->Link(at);
      const double k_te = link.stiffness * te * static_cast<double>(users - 1);
      const double drag = law->GroundDamping(at, link.stiffness * static_cast<double>(users - 1));
      const double needed = PassiveInjection(link.relative_damping / (link.stiffness * te)) * k_te;
      EXPECT_GE(drag, 1.2 * needed) << users << " users, te " << te;
    }
  }
}

// Five kilograms a tenth of a metre beside the centre of a light part move as eighty do: exact, in
// all six axes.
TEST(TwoDampings, AreStableWithHeavyHandsFarOffCentre) {
  const auto law = *MakeLaw("p+dd");
  const Inertia cube{0.3, 0.3 * 6e-4 * Mat3::Identity()};
  for (double te = 0.01; te < 2; te *= 1.6) {
    for (const double mass : {0.1, 1.0, 5.0}) {
      for (const double beside : {0.03, 0.1}) {
        const LumpedCoupling one = Under(*law, te, te, kHeaviest, 2);
        const HandImpedance hand{mass, 0.3, 0, 6e-4 * mass, 6e-4 * 0.3, 0};
        GraspCoupling coupling;
        coupling.users = {Grasp(cube, hand, Vec3(beside, 0, 0), one.damping),
                          Grasp(cube, hand, Vec3(0, -beside, 0), one.damping)};
        coupling.stiffness = one.stiffness;
        coupling.relative_damping = one.relative_damping;
        coupling.delay_s = te;
        EXPECT_TRUE(IsStable(coupling)) << "te " << te << ", " << mass << " kg at " << beside;
      }
    }
  }
}

}  // namespace
}  // namespace tandem
