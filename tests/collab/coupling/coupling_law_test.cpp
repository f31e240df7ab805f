#include "collab/coupling/coupling_law.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "collab/coupling/coupling_limits.h"

namespace tandem {
namespace {

std::shared_ptr<const CouplingLaw> Law(const char* name) {
  Result<std::shared_ptr<const CouplingLaw>> law = MakeLaw(name, {}, true);
  EXPECT_TRUE(law) << name;
  return *law;
}

double StiffnessAt(const CouplingLaw& law, double te, std::size_t users = 2, double mass = 1.5) {
  return law.Link(LawInputsAt((2.0 * te - 0.005) / 1.1, users, mass)).stiffness;
}

// The published table of p+d, sigma 0.8, B 10, K0 500, m_max 1.5: k at te.
TEST(CouplingLaw, PlusDampingGivesTheStiffnessOfItsTable) {
  const auto law = Law("p+d");
  EXPECT_NEAR(StiffnessAt(*law, 0.003), 400, 0.5);
  EXPECT_NEAR(StiffnessAt(*law, 0.020), 400, 20);
  EXPECT_NEAR(StiffnessAt(*law, 0.050), 178, 1);
  EXPECT_NEAR(StiffnessAt(*law, 0.100), 98, 1);
  EXPECT_NEAR(StiffnessAt(*law, 0.200), 58, 1);
  EXPECT_NEAR(StiffnessAt(*law, 0.300), 44, 1);
  EXPECT_NEAR(StiffnessAt(*law, 0.500), 34, 1);
  EXPECT_NEAR(StiffnessAt(*law, 1.000), 26, 1);
}

// k_crit = (b^2 + m^2 w^2) / (2 m), w tan(w tau / 2) = b / m: found by bisection, independent of
// the law's bound.
TEST(CouplingLaw, PlusDampingStaysBelowTheExactBoundary) {
  const auto law = Law("p+d");
  const double b = 10;
  for (const double m : {0.5, 1.0, 1.5}) {
    for (double tau = 0.005; tau < 1.0; tau *= 1.3) {
      double low = 0;
      double high = M_PI / tau * 0.999999;
      for (int i = 0; i < 100; ++i) {
        const double w = 0.5 * (low + high);
        (w * std::tan(0.5 * w * tau) < b / m ? low : high) = w;
      }
      const double boundary = (b * b + m * m * low * low) / (2 * m);
      EXPECT_LT(law->Link(LawInputsAt(2 * tau, 2, m)).stiffness, boundary)
          << m << " kg, " << tau << " s";
    }
  }
}

// For two users 4 b_i b_j >= (k L)^2, for more b >= sum k L/2. The mass pays for the stiffness
// beyond B/te.
TEST(CouplingLaw, PlusDampingsDragCoversItsDelayTerm) {
  const auto law = Law("p+d");
  for (const std::size_t users : {2U, 3U, 5U, 8U}) {
    for (double loop = 0.002; loop < 2.4; loop *= 1.4) {
      const LawInputs at = LawInputsAt(loop, users, 1e12);  // no help from the mass
      const double sum = law->Link(at).stiffness * static_cast<double>(users - 1);
      EXPECT_GE(law->GroundDamping(at, sum), sum * loop / 2) << users << " users, " << loop << " s";
    }
  }
}

TEST(CouplingLaw, LinearLawFallsLinearlyToItsFloor) {
  const auto law = Law("linear");
  const auto k = [&](double tau) {
    return law->Link(LawInputsAt(2 * tau, 2, 1.5)).stiffness;
  };
  EXPECT_NEAR(k(0.0), 40.0, 1e-9);
  EXPECT_NEAR(k(0.25), 30.0, 1e-9);
  EXPECT_NEAR(k(0.5), 20.0, 1e-9);
  EXPECT_NEAR(k(1.0), 0.8, 1e-9);
  EXPECT_EQ(law->GroundDamping(LawInputsAt(1.0, 2, 1.5), 20), 10.0);
  EXPECT_EQ(law->GroundDamping(LawInputsAt(1.0, 2, 1.5), 0), 0.0);
}

// k = .8 min(K0, 1.5 B/te), bc = .5 k te, b = .2 k te.
TEST(CouplingLaw, PdOptDividesDampingBetweenGroundAndLink) {
  const auto law = Law("pdopt");
  for (const double te : {0.05, 0.1, 0.3, 1.0}) {
    const LawInputs at = LawInputsAt((2.0 * te - 0.005) / 1.1, 2, 1.5);
    const LinkLaw link = law->Link(at);
    EXPECT_NEAR(link.stiffness, 12.0 / te, 1e-9);
    EXPECT_NEAR(link.relative_damping, 6.0, 1e-9);
    EXPECT_NEAR(law->GroundDamping(at, link.stiffness), 2.4, 1e-9);
    // the passivity bound of the PD link at r = .5: ground damping of .164 k te
    EXPECT_GE(law->GroundDamping(at, link.stiffness), 0.164 * link.stiffness * te);
  }
  EXPECT_NEAR(StiffnessAt(*law, 0.005), 400, 1e-9);
}

// k = 1.2 (B/te + B^2/(3 m)), bc = k te/2, b = .35 k te up to B: half as firm again as p+d.
TEST(CouplingLaw, PlusTwoDampingsIsFiftyPercentStifferThanPlusDamping) {
  const auto law = Law("p+dd");
  const auto weaker = Law("p+d");
  for (const double te : {0.03, 0.1, 0.3, 1.0}) {
    const LawInputs at = LawInputsAt((2.0 * te - 0.005) / 1.1, 2, 1.5);
    const LinkLaw link = law->Link(at);
    EXPECT_NEAR(link.stiffness, 1.5 * weaker->Link(at).stiffness, 1e-9);
    EXPECT_NEAR(link.stiffness, 12.0 / te + 1.2 * 100 / 4.5, 1e-9);
    EXPECT_NEAR(link.relative_damping, 6.0 + 0.5 * 1.2 * te * 100 / 4.5, 1e-9);
    EXPECT_NEAR(law->GroundDamping(at, link.stiffness), std::min(10.0, 0.35 * te * link.stiffness),
                1e-9);
  }
  EXPECT_NEAR(StiffnessAt(*law, 0.005), 500, 1e-9);
}

// Where drag could not pay for k te with any mass, the link is softer: it falls as 1/te, and never
// to nothing.
TEST(CouplingLaw, PlusTwoDampingsIsInverseToDelaysBeyondASecond) {
  const auto law = Law("p+dd");
  EXPECT_NEAR(StiffnessAt(*law, 1.5), 42.0 / 1.5, 1e-9);
  EXPECT_NEAR(StiffnessAt(*law, 6.0), 7.0, 1e-9);
}

TEST(CouplingLaw, ConstantLawIsReservedForTheLab) {
  EXPECT_FALSE(MakeLaw("constant"));
  const auto law = Law("constant");
  EXPECT_EQ(StiffnessAt(*law, 0.01), StiffnessAt(*law, 1.0));
}

TEST(CouplingLaw, EveryLawDividesItsStiffnessAmongTheLinks) {
  for (const char* name : {"p+d", "p+dd", "linear", "pdopt", "constant"}) {
    const auto law = Law(name);
    EXPECT_STREQ(law->name(), name);
    const LinkLaw two = law->Link(LawInputsAt(0.2, 2, 1.5));
    const LinkLaw five = law->Link(LawInputsAt(0.2, 5, 1.5));
    EXPECT_NEAR(five.stiffness, two.stiffness / 4, 1e-12);
    EXPECT_NEAR(five.relative_damping, two.relative_damping / 4, 1e-12);
  }
}

// The ratio scales the stiffness alone: drags are those of the law itself.
TEST(CouplingLaw, RatioOfOneIsReservedForTheLab) {
  EXPECT_FALSE(MakeLaw("p+dd", {.ratio = 0.5}));
  EXPECT_FALSE(MakeLaw("p+dd", {.ratio = 0}, true));
  const auto whole = *MakeLaw("p+dd");
  const auto half = *MakeLaw("p+dd", {.ratio = 0.5}, true);
  const LawInputs inputs = LawInputsAt(0.2, 2, 1.5);
  EXPECT_NEAR(half->Link(inputs).stiffness, 0.5 * whole->Link(inputs).stiffness, 1e-12);
  EXPECT_EQ(half->Link(inputs).relative_damping, whole->Link(inputs).relative_damping);
  EXPECT_NEAR(half->GroundDamping(inputs, 60), whole->GroundDamping(inputs, 120), 1e-12);
}

TEST(CouplingLaw, UnknownNameListsTheLaws) {
  const auto law = MakeLaw("stiff");
  ASSERT_FALSE(law);
  EXPECT_NE(law.error().what.find("p+d"), std::string::npos);
}

// A limit is used where a change of it changes a gain, whatever the delay and the users.
TEST(CouplingLaw, ReportsItsLimits) {
  const auto gains = [](const CouplingLaw& law) {
    std::vector<double> all;
    for (const double te : {0.003, 0.1, 1.0}) {
      const LawInputs inputs = LawInputsAt((2.0 * te - 0.005) / 1.1, 3, 1.5);
      const LinkLaw link = law.Link(inputs);
      all.insert(all.end(), {link.stiffness, link.relative_damping, law.GroundDamping(inputs, 60)});
    }
    return all;
  };
  for (const char* name : {"p+d", "p+dd", "pdopt", "linear", "constant"}) {
    const std::vector<double> usual = gains(*Law(name));
    for (const LimitName& limit : kLimitNames) {
      CouplingLimits limits;
      limits.*limit.value = 0.7 * limits.*limit.value + 0.2;
      const bool used = gains(**MakeLaw(name, limits, true)) != usual;
      EXPECT_EQ(WhyUnused(limit.name, name).empty(), used) << name << " " << limit.name;
    }
  }
  EXPECT_EQ(WhyUnused("constant_stiffness", "linear"),
            "the law 'linear' does not use it: it uses linear_stiffness, damping_budget and ratio");
}

TEST(CouplingLaw, UnknownNameIsRefusedWithAllNames) {
  for (const std::string& name : LawNames(true)) {
    EXPECT_TRUE(MakeLaw(name, {}, true)) << name;
    EXPECT_NE(MakeLaw("konstant", {}, true).error().what.find(name), std::string::npos) << name;
  }
  EXPECT_EQ(LawNames(true).size(), 5U);
  // the laws of a session without --lab
  EXPECT_EQ(LawNames(false), (std::vector<std::string>{"p+dd", "p+d", "linear", "pdopt"}));
  EXPECT_EQ(MakeLaw("konstant").error().what.find("constant"), std::string::npos);
}

}  // namespace
}  // namespace tandem
