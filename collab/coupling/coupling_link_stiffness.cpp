#include <algorithm>
#include <cmath>

#include "collab/coupling/copy_geometry.h"
#include "collab/coupling/coupling_link.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr double kSilentLoops = 1.5;  // times the longest loop age, and
constexpr double kSilentFor = 0.1;    // s more: then a peer is silent
constexpr double kBegun = 0.05;       // share of the target stiffness: below it a link begins anew
constexpr double kCapStretch = 1e-3;  // m; caps of a shorter spring are those at this stretch

}  // namespace

LinkLaw SharedStiffness::LinkAt(double loop_age_s) const noexcept {
  LawInputs alone = common;
  alone.peak_loop_age_s = std::max(common.peak_loop_age_s, loop_age_s);
  alone.te_s = DesignDelay(alone.peak_loop_age_s);
  return law.Link(alone);
}

StiffnessLimiter CouplingLink::LimitsOf(const LinkFrame& frame,
                                        const SharedStiffness& shared) const noexcept {
  const double own_speed = SpeedOf(frame.own.V_WB, frame.per_mass);
  StiffnessLimiter slew{
      .h = kFrame,
      .stretch = std::sqrt(copy_.stretch.square),
      .gentle_fall = kGentleFall * shared.falls_share,
      .rise_power = kRisePower * shared.rises_share,
      .speed = std::max(own_speed, SpeedOf(instance_.state->V_WB, frame.per_mass))};
  // a copy's move costs more with a firmer spring: a full spring leaves half the credit to it
  const double firmness =
      std::min(1.0, stiffness_.in_use / std::max(shared.allowed.stiffness, 1e-9));
  slew.energy = EnergyLeft(frame) - 0.5 * firmness * EnergyGate::kCredit;
  return slew;
}

LinkLaw CouplingLink::OfferTo(std::int64_t now_ns, const SharedStiffness& shared,
                              StiffnessLimiter& slew) noexcept {
  const double own_most = shared.LinkAt(peak_loop_age_s()).stiffness;
  // while the peer is silent, the loop grows older with the clock; the resulting fall is gentle
  const LinkLaw link = shared.LinkAt(std::max(peak_loop_age_s(), loop_age_s(now_ns)));
  const double stretch = std::max(slew.stretch, kCapStretch);
  const double offer = std::min(link.stiffness, force_limit_.most / stretch);
  const bool capped = offer < link.stiffness;
  if (capped) slew.gentle_fall = kCappedFall * shared.falls_share;
  const bool silent = loop_age_s(now_ns) > kSilentLoops * shared.longest_loop_age_s + kSilentFor;
  slew.falls_unfelt = !capped && !silent && !shared.has_newcomer;
  // the links of others to a silent peer fall as well, each by itself
  if (silent) {
    slew.gentle_fall /= static_cast<double>(std::max<std::size_t>(shared.common.users, 2) - 1);
  }
  slew.rises_unfelt = state_ == State::kEstablished;
  double& k = stiffness_.in_use;
  const double share = shared.sum > shared.most ? shared.most / shared.sum : 1.0;
  const double others = shared.sum - k;
  slew.ceiling = std::max(own_most, share * k);
  slew.wanted = offer;
  slew.reported = stiffness_.its;
  slew.room = shared.most - others;
  stiffness_.offered = std::max(offer, k);
  if (force_limit_.share < 1) {
    k = std::min(k, force_limit_.share * force_limit_.from / stretch);
    stiffness_.offered = k;
  }
  return link;
}

void CouplingLink::NoteReached(double goal) noexcept {
  if (!closed()) return;
  const double k = stiffness_.in_use;
  if (k >= goal) state_ = goal > 0 ? State::kEstablished : State::kRising;
  if (k < kBegun * goal) state_ = State::kRising;
}

void CouplingLink::Slew(const LinkFrame& frame, SharedStiffness& shared) noexcept {
  StiffnessLimiter slew = LimitsOf(frame, shared);
  if (force_limit_.share == 1) force_limit_.from = stiffness_.in_use * slew.stretch;
  LinkLaw link = shared.allowed;
  if (closed()) {
    link = OfferTo(frame.now_ns, shared, slew);
  } else {
    slew.ceiling = stiffness_.in_use;
    if (state_ == State::kListening) stiffness_.offered = 0;
    if (state_ == State::kFading) slew.fastest_gentle_fall = force_limit_.part_rate;
  }
  stiffness_.last = stiffness_.in_use;
  stiffness_.in_use = slew.Next(stiffness_.last);
  const double change = stiffness_.in_use - stiffness_.last;
  NoteReached(std::min(slew.wanted, slew.reported));
  gate_.Debit(0.5 * std::max(0.0, change) * slew.stretch * slew.stretch);
  if (closed()) shared.sum += change;
  // a spring that has yet to fall to the law's value has no more damping than that
  const double part = link.stiffness > 0 ? stiffness_.in_use / link.stiffness : 0.0;
  stiffness_.damping =
      DragAfter(kFrame, stiffness_.damping, std::min(1.0, part) * link.relative_damping);
}

}  // namespace tandem
