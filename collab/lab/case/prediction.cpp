#include "collab/lab/case/prediction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "collab/lab/case/case_parts.h"

namespace tandem {

namespace {

constexpr double kHalfFrame = 0.5e-3;   // s
constexpr double kFirmestLooked = 1e5;  // N/m, upper end of the search
constexpr double kLeastDamping = 1e-3;  // N s/m

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
  double of_bursts_s = 0;  // mean age that bursts of loss add
  double longest_s = 0;    // longest gap to be expected within two seconds
};

Gaps GapsOf(const LinkConditions& way, double publish_hz) {
  const double sample_s = 1.0 / publish_hz;
  const bool bursts = way.burst_enter > 0;
  const double length = 1.0 / std::max(1e-6, way.burst_leave);  // mean, in samples
  const double in_bursts =
      bursts ? way.burst_enter / std::max(1e-9, way.burst_enter + way.burst_leave) : 0.0;
  const double arriving = std::max(1e-3, (1.0 - way.loss) * (1.0 - in_bursts * way.burst_loss));
  Gaps gaps;
  const double mean_s = sample_s / arriving;
  // the lengths of bursts are geometric: the mean of their squares is twice the square of the mean
  const double bursts_a_sample = bursts ? (1.0 - in_bursts) * way.burst_enter : 0.0;
  const double burst_s = way.burst_loss * length * sample_s;
  gaps.of_bursts_s = bursts_a_sample / arriving * burst_s * burst_s / mean_s;
  const double bursts_a_window = 2.0 * publish_hz * bursts_a_sample;
  gaps.longest_s = std::max(mean_s, burst_s * (1.0 + std::log(std::max(1.0, bursts_a_window))));
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

/// Returns the mean age beyond the least delay of the newest sample that is applied, s, without
/// bursts of loss. Samples are applied in the order of sending, so each waits for all earlier ones.
/// The sample sent jT before the newest that can have come, at a phase x of the rate, is j T + x
/// older than the least delay. It has come with the probability c_j = min(1, (j T + x) / J), and is
/// applied as the newest with
///
///   (1 - l) c_j G_(j+1) q_j   with
///   G_j = (l + (1 - l) c_j) G_(j+1),
///   q_j = l q_(j-1) + (1 - l) (1 - c_(j-1)),
///
/// where J is the jitter, T the time between samples, l their loss; all from sample j on have come
/// with G_j, and no younger one can be applied with q_j, from q_0 = 1.
double MeanAppliedAge(double jitter_s, double sample_s, double loss) {
  constexpr int kPhases = 32;
  constexpr double kRare = 1e-7;
  // from `late` on all that is not lost has come
  const auto late = static_cast<std::size_t>(std::ceil(jitter_s / sample_s));
  const double lost = std::clamp(loss, 0.0, 0.999);
  const double most_lost = lost > kRare ? std::log(kRare) / std::log(lost) : 1.0;
  const std::size_t count = late + 1 + static_cast<std::size_t>(std::ceil(most_lost));
  std::vector<double> come(count);
  std::vector<double> all_come(count + 1, 1.0);
  double mean_s = 0;
  for (int phase = 0; phase < kPhases; ++phase) {
    const double x = (phase + 0.5) / kPhases * sample_s;
    for (std::size_t j = count; j-- > 0;) {
      const double age = x + static_cast<double>(j) * sample_s;
      come[j] = age < jitter_s ? age / jitter_s : 1.0;
      all_come[j] = (lost + (1.0 - lost) * come[j]) * all_come[j + 1];
    }
    double none_younger = 1;
    for (std::size_t j = 0; j < count; ++j) {
      const double age = x + static_cast<double>(j) * sample_s;
      mean_s += age * (1.0 - lost) * come[j] * all_come[j + 1] * none_younger / kPhases;
      none_younger = lost * none_younger + (1.0 - lost) * (1.0 - come[j]);
    }
  }
  return mean_s;
}

/// Returns the mean age over one way beyond its least delay, s.
double MeanHeld(const LinkConditions& way, double publish_hz) {
  const Gaps gaps = GapsOf(way, publish_hz);
  return MeanAppliedAge(1e-3 * way.jitter_ms, 1.0 / publish_hz, way.loss) + gaps.of_bursts_s;
}

// returns the loop age that the law uses: the worst of the last seconds
double PeakLoopAge(const LabCase& test) {
  const double oneway_s =
      test.delay_s + OfBothWays(test.network, [&test](const LinkConditions& way) {
        return 1e-3 * (way.delay_ms + way.jitter_ms) + TracedAge(way.trace) +
               TracedPeak(way.trace) + GapsOf(way, test.publish_hz).longest_s;
      });
  return 2.0 * oneway_s;
}

}  // namespace

const char* NameOf(Prediction::Covers covers) {
  return covers == Prediction::Covers::kMotion ? "six axes" : "passivity";
}

double MeanAge(const LabCase& test) {
  return test.delay_s + kHalfFrame + OfBothWays(test.network, [&test](const LinkConditions& way) {
           return 1e-3 * way.delay_ms + TracedAge(way.trace) + MeanHeld(way, test.publish_hz);
         });
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
  if (!test.IsFree()) prediction.covers = Prediction::Covers::kPassivity;
  if (test.IsFree() && !AllHoldAlikeAtTheCentre(test)) {
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
    const double critical = test.IsFree() ? CriticalStiffness(*lumped)
                                          : PassiveStiffness(lumped->delay_s, lumped->damping);
    prediction.critical = std::min(prediction.critical, critical);
  }
  return prediction;
}

}  // namespace tandem
