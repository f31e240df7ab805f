#include <algorithm>
#include <cmath>

#include "collab/coupling/shared_body.h"
#include "collab/coupling/stiffness_slew.h"
#include "collab/session/planted_faults.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr double kSilentLoops = 1.5;  // times the longest loop age, and
constexpr double kSilentFor = 0.1;    // s more: then a partner is silent
constexpr double kBegun = 0.05;       // share of the target stiffness: below it a link begins anew

/// Returns the speed in m/s, rotation included. `per_mass`: rotational inertia in W over the mass,
/// m^2.
double SpeedOf(const Twist& V_WB, const Mat3& per_mass) {
  return std::sqrt(V_WB.v.squaredNorm() + V_WB.w.dot(per_mass * V_WB.w));
}

}  // namespace

/// Values that all links share in a frame.
struct SharedBody::SlewFrame {
  std::int64_t now_ns = 0;
  const LawInputs& common;
  const Mat3& per_mass;
  double own_speed = 0;
  LinkLaw allowed;
  double most = 0;  // N/m; largest sum of stiffnesses
  double sum = 0;   // N/m; over the closed links, as they change in the frame
  // a newcomer shares the sum of fewer links, and has nothing of it before these have less
  bool has_newcomer = false;
  // gentle is the sum over all links that the hand feels, as when a cut takes or gives back all
  // partners
  double falls_share = 1;
  double rises_share = 1;

  /// Returns the law's link for a loop that is older than that of all links.
  LinkLaw LinkAt(double loop_age_s, const CouplingLaw& law) const noexcept {
    LawInputs alone = common;
    alone.peak_loop_age_s = std::max(common.peak_loop_age_s, loop_age_s);
    alone.te_s = DesignDelay(alone.peak_loop_age_s);
    return law.Link(alone);
  }
};

inline StiffnessSlew SharedBody::LimitsOf(const SlewFrame& frame,
                                          const Partner& partner) const noexcept {
  StiffnessSlew slew{
      .h = kFrame,
      .stretch = std::sqrt(partner.stretch.square),
      .gentle_fall = kGentleFall * frame.falls_share,
      .rise_power = kRisePower * frame.rises_share,
      .speed = std::max(frame.own_speed, SpeedOf(partner.state.V_WB, frame.per_mass))};
  // a copy's move costs more with a firmer spring: a full spring leaves half the credit to it
  if (options_.gate) {
    const double firmness =
        std::min(1.0, partner.stiffness / std::max(frame.allowed.stiffness, 1e-9));
    slew.energy = partner.gate.tank() - 0.5 * firmness * EnergyGate::kCredit;
  }
  return slew;
}

inline LinkLaw SharedBody::OfferTo(const SlewFrame& frame, Partner& partner,
                                   StiffnessSlew& slew) const noexcept {
  const double own_most = frame.LinkAt(partner.meter.peak_loop_age_s(), *options_.law).stiffness;
  // while the partner is silent, the loop grows older with the clock; the resulting fall is
  // gentle
  const LinkLaw link = frame.LinkAt(
      std::max(partner.meter.peak_loop_age_s(), partner.loop_age_s(frame.now_ns)), *options_.law);
  const double offer = std::min(link.stiffness, partner.most_force / std::max(slew.stretch, 1e-3));
  const bool capped = offer < link.stiffness;
  if (capped) slew.gentle_fall = kCappedFall * frame.falls_share;
  const bool silent =
      partner.loop_age_s(frame.now_ns) > kSilentLoops * longest_loop_age_s_ + kSilentFor;
  slew.falls_unfelt = !capped && !silent && !frame.has_newcomer;
  // the links of others to a silent partner fall as well, each by itself
  if (silent) {
    slew.gentle_fall /= static_cast<double>(std::max<std::size_t>(frame.common.users, 2) - 1);
  }
  slew.rises_unfelt = partner.reached;
  const double share = frame.sum > frame.most ? frame.most / frame.sum : 1.0;
  const double others = frame.sum - partner.stiffness;
  const double own_ceiling = std::max(own_most, share * partner.stiffness);
  partner.offered_stiffness = std::max(offer, partner.stiffness);
  if (partner.fade_share < 1) {
    const double faded = partner.fade_share * partner.fade_from / std::max(slew.stretch, 1e-3);
    partner.stiffness = std::min(partner.stiffness, faded);
    partner.offered_stiffness = partner.stiffness;
  }
  slew.ceiling = own_ceiling;
  slew.wanted = offer;
  slew.told = partner.its_stiffness;
  slew.room = frame.most - others;
  return link;
}

inline void SharedBody::SlewLink(SlewFrame& frame, Partner& partner) noexcept {
  StiffnessSlew slew = LimitsOf(frame, partner);
  if (partner.fade_share == 1) partner.fade_from = partner.stiffness * slew.stretch;
  LinkLaw link = frame.allowed;
  if (!partner.present) {
    slew.ceiling = partner.stiffness;
    slew.gentlest = Planted(Fault::kFadeNever) ? 0.0 : partner.fade_rate;
  } else if (partner.closed()) {
    link = OfferTo(frame, partner, slew);
  } else {
    partner.offered_stiffness = 0;
    slew.ceiling = partner.stiffness;
  }
  const double before = partner.stiffness;
  partner.stiffness = slew.Next(before);
  const double goal = std::min(slew.wanted, slew.told);
  if (partner.stiffness >= goal) partner.reached = goal > 0;
  if (partner.stiffness < kBegun * goal) partner.reached = false;
  partner.falls = partner.stiffness < before;
  partner.rises = partner.stiffness > before;
  const double rise = std::max(0.0, partner.stiffness - before);
  partner.gate.Charge(0.5 * rise * slew.stretch * slew.stretch);
  if (partner.closed()) frame.sum += partner.stiffness - before;
  // a spring that has yet to fall to the law's value has no more damping than that
  const double part = link.stiffness > 0 ? partner.stiffness / link.stiffness : 0.0;
  partner.relative_damping =
      DragAfter(kFrame, partner.relative_damping, std::min(1.0, part) * link.relative_damping);
}

void SharedBody::Slew(std::int64_t now_ns, const LawInputs& common, const Twist& V_own_WB,
                      const Mat3& per_mass) noexcept {
  SlewFrame frame{.now_ns = now_ns,
                  .common = common,
                  .per_mass = per_mass,
                  .own_speed = SpeedOf(V_own_WB, per_mass),
                  .allowed = options_.law->Link(common)};
  frame.most = frame.allowed.stiffness * static_cast<double>(common.users - 1);
  for (const Partner& partner : partners_) {
    if (partner.closed()) frame.sum += partner.stiffness;
  }
  frame.has_newcomer = std::ranges::any_of(partners_, [](const Partner& partner) {
    return partner.closed() && !partner.reached;
  });
  const auto share_of = [this](bool Partner::*moves) {
    return 1.0 / std::max(1.0, static_cast<double>(std::ranges::count_if(partners_, moves)));
  };
  frame.falls_share = share_of(&Partner::falls);
  frame.rises_share = share_of(&Partner::rises);
  for (Partner& partner : partners_) {
    if (partner.heard) SlewLink(frame, partner);
  }
}

}  // namespace tandem
