#include "collab/lab/prediction.h"

#include <algorithm>
#include <limits>

#include "collab/lab/case_parts.h"

namespace tandem {

namespace {

constexpr double kHalfFrame = 0.5e-3;  // s

bool IsFree(const LabCase& test) {
  return test.scene == "free" || test.scene == "off_centre";
}

// both ways alike: only their sum matters
template <class Value>
double OfBothWays(const LabNetwork& network, Value value) {
  return 0.5 * (value(network.there) + value(network.back));
}

// s, from one sample that arrives to the next
double MeanGap(const LabCase& test) {
  return OfBothWays(test.network, [&test](const LinkConditions& way) {
    return 1.0 / (test.publish_hz * std::max(1e-3, 1.0 - way.loss));
  });
}

// by how much what a receiver holds is older than samples of the trace's rate without delay, s
double TracedAge(const LinkTrace* trace) {
  if (trace == nullptr) return 0;
  return std::max(0.0, 1e-3 * trace->facts().mean_age_ms - 0.5 / trace->rate_hz());
}

// by how much the oldest is older than the mean, s
double TracedPeak(const LinkTrace* trace) {
  if (trace == nullptr) return 0;
  return 1e-3 * (trace->facts().peak_age_ms - trace->facts().mean_age_ms);
}

double MeanDelay(const LabCase& test) {
  return test.delay_s + OfBothWays(test.network, [](const LinkConditions& way) {
           return 1e-3 * (way.delay_ms + 0.5 * way.jitter_ms) + TracedAge(way.trace);
         });
}

// what the law is told: the worst of the last seconds
double PeakLoopAge(const LabCase& test) {
  const double jitter_s = OfBothWays(test.network, [](const LinkConditions& way) {
    return 0.5e-3 * way.jitter_ms + TracedPeak(way.trace);
  });
  return 2.0 * (MeanDelay(test) + jitter_s + MeanGap(test));
}

}  // namespace

double MeanAge(const LabCase& test) {
  return MeanDelay(test) + 0.5 * MeanGap(test) + kHalfFrame;
}

std::optional<LumpedCoupling> LumpedOf(const LabCase& test, const Inertia& body, std::size_t user) {
  const auto law = LawOf(test.law);
  if (!law || !test.network.schedule.empty() || test.law.exchange_forces) return std::nullopt;
  const LawInputs inputs = LawInputsAt(PeakLoopAge(test), test.users, LawInputs{}.mass_max);
  const LinkLaw link = (*law)->Link(inputs);
  const auto others = static_cast<double>(test.users - 1);
  const HandImpedance hand = ScriptOf(test, user, {}).impedance;
  LumpedCoupling lumped;
  lumped.stiffness = others * link.stiffness;
  lumped.relative_damping = others * link.relative_damping;
  lumped.mass = body.mass + hand.mass;
  lumped.damping = hand.damping + (*law)->GroundDamping(inputs, lumped.stiffness);
  lumped.hand_stiffness = hand.stiffness;
  lumped.delay_s = MeanAge(test);
  lumped.users = test.users;
  return lumped;
}

std::optional<Prediction> Predict(const LabCase& test, const Inertia& body) {
  Prediction prediction{0, std::numeric_limits<double>::infinity()};
  for (std::size_t user = 0; user < test.users; ++user) {
    const std::optional<LumpedCoupling> lumped = LumpedOf(test, body, user);
    if (!lumped) return std::nullopt;
    prediction.stiffness = lumped->stiffness;
    const double critical = IsFree(test) ? CriticalStiffness(*lumped)
                                         : PassiveStiffness(lumped->delay_s, lumped->damping);
    prediction.critical = std::min(prediction.critical, critical);
  }
  return prediction;
}

}  // namespace tandem
