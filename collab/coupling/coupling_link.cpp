#include "collab/coupling/coupling_link.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collab/coupling/copy_geometry.h"
#include "collab/receive/newer.h"
#include "engine/base/units.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr std::int64_t kSilenceNs = 250'000'000;  // after this silence a copy comes back slowly
constexpr double kGentleStep = 0.05;              // N a frame; force change by that slow move
constexpr double kMostStep = 0.8;     // N a frame; force change by any move and velocity of a copy
constexpr double kQuietAfter = 0.02;  // s of silence, after which a copy's velocity fades
constexpr double kQuietTime = 0.1;    // s; time of that fade
constexpr double kHeardTime = 0.02;   // s; time in which a copy's velocity comes back

}  // namespace

void CouplingLink::Rejoin() noexcept {
  if (state_ != State::kFading) return;
  state_ = State::kListening;
  copy_.is_catching_up = true;
  loop_.echo_ns.reset();
  loop_.meter = DelayMeter{};
}

void CouplingLink::Part() noexcept {
  if (state_ == State::kFading) return;
  state_ = State::kFading;
  force_limit_.part_rate = stiffness_.in_use / kFadeTime;
}

void CouplingLink::OnState(const ObjectState& state) noexcept {
  if (state_ == State::kFading) return;
  if (received() && !IsNewer(state, *instance_.state)) return;
  instance_.state = state;
  instance_.is_fresh = true;
  CloseLoop();
}

std::size_t CouplingLink::OnLinks(const CouplingLinks& links, PeerId self,
                                  const SentStamps& sent) noexcept {
  if (state_ == State::kFading) return 0;
  if (loop_.echo_ns && !IsAfter(links.seq, loop_.links_seq)) return 0;
  std::size_t refused = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(links.count, kMaxLinks); ++i) {
    const LinkEntry& entry = links.entries[i];
    if (entry.to != self || entry.echo_ns == 0) continue;
    if (!sent.Has(entry.echo_ns) || (loop_.echo_ns && entry.echo_ns < *loop_.echo_ns)) {
      ++refused;
      continue;
    }
    Take(entry);
    loop_.links_seq = links.seq;
  }
  CloseLoop();
  return refused;
}

void CouplingLink::Take(const LinkEntry& entry) noexcept {
  if (!loop_.echo_ns) loop_.measured_ns = entry.echo_ns;
  // a repeated echo is no news: the peer has not heard us since
  loop_.is_fresh = loop_.is_fresh || !loop_.echo_ns || entry.echo_ns != *loop_.echo_ns;
  loop_.echo_ns = entry.echo_ns;
  stiffness_.its = std::max(0.0, entry.stiffness);
  its_applied_B_W_ = entry.applied_B_W;
  gate_.Receive(entry.gate_overflow);
}

void CouplingLink::CloseLoop() noexcept {
  if (state_ == State::kListening && received() && loop_.echo_ns) state_ = State::kRising;
}

void CouplingLink::CapForce(double newtons) noexcept {
  force_limit_.most = newtons;
  force_limit_.share = 1;
}

void CouplingLink::Measure(std::int64_t now_ns, std::int64_t last_frame_ns) noexcept {
  if (std::exchange(instance_.is_fresh, false)) {
    const bool silent = instance_.arrived_ns != 0 && now_ns - instance_.arrived_ns > kSilenceNs;
    copy_.is_catching_up = copy_.is_catching_up || silent;
    instance_.arrived_ns = now_ns;
  }
  if (!closed()) return;
  loop_.meter.Forget(now_ns);
  if (!std::exchange(loop_.is_fresh, false)) return;
  // its age in the frame before the new echo; the peak of a silence counts then
  const std::int64_t before_ns = last_frame_ns - loop_.measured_ns;
  const std::int64_t age_ns = now_ns - *loop_.echo_ns;
  if (before_ns > age_ns) loop_.meter.Add(last_frame_ns, before_ns);
  loop_.meter.Add(now_ns, age_ns);
  loop_.measured_ns = *loop_.echo_ns;
}

void CouplingLink::MoveCopy(const LinkFrame& frame) noexcept {
  const double k = stiffness_.in_use;
  // as far as the force may change in a frame, then as far as the gate's energy allows
  Pose next = instance_.state->X_WB;
  const double step = copy_.is_catching_up ? kGentleStep : kMostStep;
  const double way = k > 0 ? LinkDistance(copy_.X_WB, next, frame.per_mass) : 0.0;
  const double share = k > 0 ? step / (k * way) : 1.0;
  if (share < 1) {
    next = Interpolate(copy_.X_WB, next, share);
  } else {
    copy_.is_catching_up = false;
  }
  const Pose last = copy_.X_WB;
  LetThrough(next, frame);
  const bool whole = share >= 1 && !gate_.clipped();
  copy_.way_force = k * (whole ? way : LinkDistance(last, copy_.X_WB, frame.per_mass));
}

void CouplingLink::MoveTwist(const LinkFrame& frame) noexcept {
  // the copy of a silent peer stands
  const double quiet = ToSeconds(frame.now_ns - instance_.arrived_ns) - kQuietAfter;
  copy_.moving =
      std::min(std::clamp(1.0 - quiet / kQuietTime, 0.0, 1.0), copy_.moving + kFrame / kHeardTime);
  const double b = stiffness_.damping;
  const Twist& V_WB = instance_.state->V_WB;
  const Twist wanted{copy_.moving * V_WB.w, copy_.moving * V_WB.v};
  // the damper gets the part of a frame's force change that the spring leaves
  const double room = std::max(0.0, kMostStep - copy_.way_force);
  copy_.V_WB = b > 0 ? TwistTowards(copy_.V_WB, wanted, room / b, frame.per_mass) : wanted;
  // power that the damper gives, less the power that it takes
  const Twist& V_own_WB = frame.own.V_WB;
  const double given = kFrame * b *
                       ((copy_.V_WB.v - V_own_WB.v).dot(V_own_WB.v) +
                        (copy_.V_WB.w - V_own_WB.w).dot(frame.per_mass * V_own_WB.w));
  if (given <= 0) {
    gate_.Credit(-given);
  } else if (given > EnergyLeft(frame)) {
    copy_.V_WB = {};
  } else {
    gate_.Debit(given);
  }
}

void CouplingLink::Couple(const LinkFrame& frame, StepInputs::Link& link) noexcept {
  MoveTwist(frame);
  const Pose& X_WB = frame.own.X_WB;
  link.copy = {
      {ClampedTurn(X_WB.q, copy_.X_WB.q, copy_.stretch.turn, copy_.turn_axis), copy_.X_WB.p},
      copy_.V_WB};
  const double k = stiffness_.in_use;
  const double b = stiffness_.damping;
  link.gains = {k, b, k * frame.per_mass, b * frame.per_mass};
  ExchangeForces(frame, link);
}

LinkEntry CouplingLink::Describe(PeerId to) const noexcept {
  return {.to = to,
          .echo_ns = instance_.state->sample_ns,
          .stiffness = stiffness_.offered,
          .gate_overflow = gate_.overflow(),
          .applied_B_W = told_B_W()};
}

LinkView CouplingLink::View(PeerId peer, std::int64_t now_ns, double gyration) const noexcept {
  const auto size = [gyration](const Wrench& F) {
    return std::sqrt(F.f.squaredNorm() + F.tau.squaredNorm() / (gyration * gyration));
  };
  Wrench sum = applied_B_W_;
  sum += its_applied_B_W_;
  const double larger = std::max(size(applied_B_W_), size(its_applied_B_W_));
  return {.peer = peer,
          .closed = closed(),
          .loop_age_s = loop_age_s(now_ns),
          .te_s = DesignDelay(peak_loop_age_s()),
          .stiffness = stiffness_.in_use,
          .force = applied_B_W_.f.norm(),
          .its_force = its_applied_B_W_.f.norm(),
          .tank = gate_.tank(),
          .clipped = gate_.clipped(),
          .disagreement = larger > 0 ? size(sum) / larger : 0.0};
}

// Experiments of the lab.

void CouplingLink::LetThrough(const Pose& next, const LinkFrame& frame) noexcept {
  if (!frame.experiments.energy_gate) {
    copy_.X_WB = next;
    copy_.stretch = EnergyGate::StretchOf(next, frame.own, frame.per_mass);
    return;
  }
  copy_.X_WB = gate_.Modulate(next, frame.own, stiffness_.in_use, frame.per_mass);
  copy_.stretch = gate_.stretch();
}

double CouplingLink::EnergyLeft(const LinkFrame& frame) const noexcept {
  constexpr double kNoBound = 1e30;
  return frame.experiments.energy_gate ? gate_.tank() : kNoBound;
}

void CouplingLink::ExchangeForces(const LinkFrame& frame, StepInputs::Link& link) noexcept {
  if (!frame.experiments.exchange_forces) return;
  // the wire carries the force on the sender's end: the other end's is opposite to ours
  computed_B_W_ = AsWrench(CouplingForce(link.gains, frame.own, Pose{}, link.copy).force);
  link.gains = {};
  link.push_B_W = {-its_applied_B_W_.tau, -its_applied_B_W_.f};
}

}  // namespace tandem
