#include "collab/lab/prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collab/lab/case_parts.h"

namespace tandem {

namespace {

constexpr double kHalfFrame = 0.5e-3;   // s
constexpr double kFirmestLooked = 1e5;  // N/m, upper end of the search
constexpr double kLeastDamping = 1e-3;  // N s/m

bool IsFree(const LabCase& test) {
  return test.scene == "free" || test.scene == "off_centre";
}

bool AllHoldAlikeAtTheCentre(const LabCase& test) {
  const HandScript first = ScriptOf(test, 0);
  for (std::size_t user = 0; user < test.users; ++user) {
    const HandScript script = ScriptOf(test, user);
    const HandImpedance& a = first.impedance;
    const HandImpedance& b = script.impedance;
    if (!script.X_BD.p.isZero() || a.mass != b.mass || a.damping != b.damping ||
        a.stiffness != b.stiffness) {
      return false;
    }
  }
  return true;
}

// the mean of both ways; only their sum matters
template <class Value>
double OfBothWays(const LabNetwork& network, Value value) {
  return 0.5 * (value(network.there) + value(network.back));
}

/// The gaps between the samples that arrive over one way with loss.
struct Gaps {
  double mean_s = 0;
  double mean_square_s2 = 0;
  double longest_s = 0;  // longest gap to be expected within two seconds
};

Gaps GapsOf(const LinkConditions& way, double publish_hz) {
  const double sample_s = 1.0 / publish_hz;
  const bool bursts = way.burst_enter > 0;
  const double length = 1.0 / std::max(1e-6, way.burst_leave);  // mean, in samples
  const double in_bursts =
      bursts ? way.burst_enter / std::max(1e-9, way.burst_enter + way.burst_leave) : 0.0;
  const double arriving = std::max(1e-3, (1.0 - way.loss) * (1.0 - in_bursts * way.burst_loss));
  Gaps gaps;
  gaps.mean_s = sample_s / arriving;
  // bursts' lengths are geometric: the mean of the squares is about twice the square of the mean
  const double bursts_a_sample = bursts ? (1.0 - in_bursts) * way.burst_enter : 0.0;
  const double burst_s = way.burst_loss * length * sample_s;
  gaps.mean_square_s2 =
      gaps.mean_s * gaps.mean_s + 2.0 * bursts_a_sample / arriving * burst_s * burst_s;
  const double bursts_a_window = 2.0 * publish_hz * bursts_a_sample;
  gaps.longest_s =
      std::max(gaps.mean_s, burst_s * (1.0 + std::log(std::max(1.0, bursts_a_window))));
  return gaps;
}

// returns the age of a receiver's data beyond that of samples at the trace's rate without delay, s
double TracedAge(const LinkTrace* trace) {
  if (trace == nullptr) return 0;
  return std::max(0.0, 1e-3 * trace->facts().mean_age_ms - 0.5 / trace->rate_hz());
}

// returns the age of the oldest data beyond the mean age, s
double TracedPeak(const LinkTrace* trace) {
  if (trace == nullptr) return 0;
  return 1e-3 * (trace->facts().peak_age_ms - trace->facts().mean_age_ms);
}

double MeanDelay(const LabCase& test) {
  return test.delay_s + OfBothWays(test.network, [](const LinkConditions& way) {
           return 1e-3 * (way.delay_ms + 0.5 * way.jitter_ms) + TracedAge(way.trace);
         });
}

// returns the loop age that the law uses: the worst of the last seconds
double PeakLoopAge(const LabCase& test) {
  const double more_s = OfBothWays(test.network, [&test](const LinkConditions& way) {
    return 0.5e-3 * way.jitter_ms + TracedPeak(way.trace) + GapsOf(way, test.publish_hz).longest_s;
  });
  return 2.0 * (MeanDelay(test) + more_s);
}

}  // namespace

const char* NameOf(Prediction::Covers covers) {
  return covers == Prediction::Covers::kMotion ? "six axes" : "passivity";
}

double MeanAge(const LabCase& test) {
  // the data are on average half as old as the gap in which they are held is long
  const double held_s = OfBothWays(test.network, [&test](const LinkConditions& way) {
    const Gaps gaps = GapsOf(way, test.publish_hz);
    return 0.5 * gaps.mean_square_s2 / gaps.mean_s;
  });
  return MeanDelay(test) + held_s + kHalfFrame;
}

std::optional<LumpedCoupling> LumpedOf(const LabCase& test, const Inertia& body, std::size_t user) {
  const auto law = LawOf(test.law);
  if (!law || !test.network.schedule.empty() || test.law.exchange_forces) return std::nullopt;
  const LawInputs inputs = LawInputsAt(PeakLoopAge(test), test.users, LawInputs{}.mass_max);
  const LinkLaw link = (*law)->Link(inputs);
  const auto others = static_cast<double>(test.users - 1);
  const HandImpedance hand = ScriptOf(test, user).impedance;
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

std::optional<GraspCoupling> GraspCouplingOf(const LabCase& test, const Inertia& body) {
  GraspCoupling coupling;
  for (std::size_t user = 0; user < test.users; ++user) {
    const std::optional<LumpedCoupling> lumped = LumpedOf(test, body, user);
    if (!lumped) return std::nullopt;
    const HandScript script = ScriptOf(test, user);
    coupling.stiffness = lumped->stiffness;
    coupling.relative_damping = lumped->relative_damping;
    coupling.delay_s = lumped->delay_s;
    const double of_law = lumped->damping - script.impedance.damping;
    coupling.users.push_back(Grasp(body, script.impedance, script.X_BD.p, of_law));
  }
  return coupling;
}

std::optional<Prediction> Predict(const LabCase& test, const Inertia& body) {
  const std::optional<LumpedCoupling> first = LumpedOf(test, body, 0);
  if (!first) return std::nullopt;
  Prediction prediction{first->stiffness, std::numeric_limits<double>::infinity()};
  if (!IsFree(test)) prediction.covers = Prediction::Covers::kPassivity;
  if (IsFree(test) && !AllHoldAlikeAtTheCentre(test)) {
    const std::optional<GraspCoupling> coupling = GraspCouplingOf(test, body);
    double damping = std::numeric_limits<double>::infinity();
    for (std::size_t user = 0; user < test.users; ++user) {
      damping = std::min(
          damping, LumpedOf(test, body, user)->damping - ScriptOf(test, user).impedance.damping);
    }
    const double passive = PassiveStiffness(coupling->delay_s, std::max(damping, kLeastDamping));
    prediction.critical =
        CriticalStiffness(*coupling, std::min(passive, kFirmestLooked), kFirmestLooked);
    return prediction;
  }
  for (std::size_t user = 0; user < test.users; ++user) {
    const std::optional<LumpedCoupling> lumped = LumpedOf(test, body, user);
    const double critical = IsFree(test) ? CriticalStiffness(*lumped)
                                         : PassiveStiffness(lumped->delay_s, lumped->damping);
    prediction.critical = std::min(prediction.critical, critical);
  }
  return prediction;
}

}  // namespace tandem
