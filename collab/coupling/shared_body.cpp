#include "collab/coupling/shared_body.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collab/coupling/copy_geometry.h"
#include "collab/coupling/stiffness_slew.h"
#include "collab/receive/newer.h"
#include "collab/session/planted_faults.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr double kArmMass = 1.2;      // kg; hand and device that may move with the body
constexpr double kQuietAfter = 0.02;  // s of silence, after which a copy's velocity fades
constexpr std::int64_t kSilenceNs = 250'000'000;  // after this silence a copy comes back slowly
constexpr double kGentleStep = 0.05;              // N a frame; force change by that slow move
constexpr double kMostStep = 0.8;   // N a frame; force change by any move and velocity of a copy
constexpr double kQuietTime = 0.1;  // s; time of that fade
constexpr double kForgetting = 1.0 - kFrame / 120;  // factor of a frame on the longest loop age
constexpr double kNext = 1e-9;                      // N/m; sum of links that are to rise from 0
constexpr double kHeardTime = 0.02;                 // s; time in which a copy's velocity comes back

double Seconds(std::int64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

}  // namespace

SharedBody::SharedBody(PeerId self, ObjectId object, const Inertia& inertia, const Options& options)
    : self_(self),
      object_(object),
      inertia_(inertia),
      gyration_(std::sqrt(0.5 * inertia.I_B.trace() / inertia.mass)),
      options_(options) {}

Partner* SharedBody::Find(PeerId peer) noexcept {
  const auto it = std::find_if(partners_.begin(), partners_.end(), [peer](const Partner& p) {
    return p.peer == peer;
  });
  return it == partners_.end() ? nullptr : &*it;
}

bool SharedBody::Join(PeerId peer) noexcept {
  Partner* partner = Find(peer);
  if (partner != nullptr && partner->present) return true;
  if (partner != nullptr) {  // back while its pull still fades: it goes on from there
    partner->present = true;
    partner->linked = false;
    partner->catching_up = true;
    partner->reached = false;
    partner->meter = DelayMeter{};
    return true;
  }
  partner = Find(0);
  if (partner == nullptr) return false;
  *partner = Partner{};
  partner->peer = peer;
  partner->present = true;
  return true;
}

void SharedBody::Part(PeerId peer) noexcept {
  Partner* partner = Find(peer);
  if (partner == nullptr || !partner->present) return;
  partner->present = false;
  partner->fade_rate = partner->stiffness / kFadeTime;
}

void SharedBody::OnState(const ObjectState& state) noexcept {
  if (state.object != object_) return;
  Partner* partner = Find(state.peer);
  if (partner == nullptr || !partner->present) return;
  if (partner->heard && !IsNewer(state, partner->state)) return;
  partner->state = state;
  partner->heard = true;
  partner->fresh_state = true;
}

void SharedBody::OnLinks(const CouplingLinks& links) noexcept {
  if (links.object != object_) return;
  Partner* partner = Find(links.from);
  if (partner == nullptr || !partner->present) return;
  if (partner->linked && !IsAfter(links.seq, partner->links_seq)) return;
  for (std::size_t i = 0; i < std::min<std::size_t>(links.count, kMaxLinks); ++i) {
    const LinkEntry& entry = links.entries[i];
    if ((entry.to != self_ && !Planted(Fault::kEchoForAnother)) || entry.echo_ns == 0) continue;
    if (!sent_.Has(entry.echo_ns) || (partner->linked && entry.echo_ns < partner->echo_ns)) {
      ++bad_echoes_;
      continue;
    }
    if (!partner->linked) partner->last_echo_ns = entry.echo_ns;
    // a repeated echo is no news: the partner has not heard us since
    partner->fresh_echo =
        partner->fresh_echo || !partner->linked || entry.echo_ns != partner->echo_ns;
    partner->echo_ns = entry.echo_ns;
    partner->its_stiffness = std::max(0.0, entry.stiffness);
    partner->its_applied_B_W = entry.applied_B_W;
    partner->gate.Receive(entry.gate_overflow);
    partner->links_seq = links.seq;
    partner->linked = true;
  }
}

std::size_t SharedBody::Instances(std::array<InstanceView, kMaxLinks>& out) const noexcept {
  std::size_t count = 0;
  for (const Partner& partner : partners_) {
    if (partner.present && partner.heard) out[count++] = {partner.peer, partner.state.X_WB};
  }
  return count;
}

void SharedBody::CapForce(PeerId peer, double newtons) noexcept {
  Partner* const partner = Find(peer);
  if (partner == nullptr) return;
  partner->most_force = newtons;
  partner->fade_share = 1;
}

void SharedBody::FadeForce(PeerId peer, double share) noexcept {
  if (Partner* partner = Find(peer)) partner->fade_share = share;
}

double SharedBody::WorstLoopAge() const noexcept {
  double worst = 0;
  for (const Partner& partner : partners_) {
    if (partner.closed()) worst = std::max(worst, partner.meter.peak_loop_age_s());
  }
  return worst;
}

LawInputs SharedBody::MeasureDelays(std::int64_t now_ns) noexcept {
  double peak = 0;
  std::size_t users = 1;
  longest_loop_age_s_ *= kForgetting;
  for (Partner& partner : partners_) {
    if (std::exchange(partner.fresh_state, false)) {
      const bool silent = partner.heard_ns != 0 && now_ns - partner.heard_ns > kSilenceNs;
      partner.catching_up = partner.catching_up || silent;
      partner.heard_ns = now_ns;
    }
    if (!partner.closed()) continue;
    partner.meter.Forget(now_ns);
    if (std::exchange(partner.fresh_echo, false)) {
      // its age in the frame before the new echo; the peak of a silence counts then
      const std::int64_t before_ns = last_frame_ns_ - partner.last_echo_ns;
      const std::int64_t age_ns = partner.loop_age_ns(now_ns);
      if (before_ns > age_ns) partner.meter.Add(last_frame_ns_, before_ns);
      partner.meter.Add(now_ns, age_ns);
      partner.last_echo_ns = partner.echo_ns;
    }
    longest_loop_age_s_ = std::max(longest_loop_age_s_, partner.meter.peak_loop_age_s());
    delay_sum_s_ += 0.5 * partner.loop_age_s(now_ns);
    ++delays_;
    ++users;
    peak = std::max(peak, std::min(partner.meter.peak_loop_age_s(), kLongestCommonLoop));
  }
  last_frame_ns_ = now_ns;
  return LawInputsAt(peak, users, inertia_.mass + kArmMass);
}

void SharedBody::Admit(const RigidState& own, const Mat3& per_mass) noexcept {
  double sum = 0;
  for (const Partner& partner : partners_) sum += partner.stiffness;
  const double lost =
      kFrame * ground_damping_ * (own.V_WB.v.squaredNorm() + own.V_WB.w.dot(per_mass * own.V_WB.w));
  const auto closed = static_cast<double>(coupled());
  for (Partner& partner : partners_) {
    if (!partner.heard) continue;
    if (sum > 0) {
      partner.gate.Earn(lost * partner.stiffness / sum);
    } else if (partner.closed()) {
      partner.gate.Earn(lost / closed);
    }
    // as far as the force may change in a frame, then as far as the gate's energy allows
    Pose next = partner.state.X_WB;
    const double step = partner.catching_up ? kGentleStep : kMostStep;
    const double way = partner.stiffness > 0 ? LinkDistance(partner.copy_WB, next, per_mass) : 0.0;
    const double share = partner.stiffness > 0 ? step / (partner.stiffness * way) : 1.0;
    if (share < 1) {
      next = Between(partner.copy_WB, next, share);
    } else {
      partner.catching_up = false;
    }
    const Pose last = partner.copy_WB;
    if (options_.gate) {
      partner.copy_WB = partner.gate.Admit(next, own, partner.stiffness, per_mass);
      partner.stretch = partner.gate.stretch();
    } else {
      partner.copy_WB = next;
      partner.stretch = EnergyGate::StretchOf(next, own, per_mass);
    }
    const bool whole = share >= 1 && !(options_.gate && partner.gate.clipped());
    partner.way_force =
        partner.stiffness * (whole ? way : LinkDistance(last, partner.copy_WB, per_mass));
  }
}

void SharedBody::Prepare(std::int64_t now_ns, const RigidState& own, StepInputs& inputs) noexcept {
  const Mat3 R = own.X_WB.q.toRotationMatrix();
  const Mat3 per_mass = R * inertia_.I_B * R.transpose() / inertia_.mass;
  LawInputs common = MeasureDelays(now_ns);
  if (Planted(Fault::kUsersInPlaceOfLinks)) ++common.users;
  if (Planted(Fault::kEveryLinkWhole)) common.users = 2;
  Admit(own, per_mass);
  Slew(now_ns, common, own.V_WB, per_mass);

  double stiffness_sum = 0;
  link_count_ = 0;
  for (std::size_t i = 0; i < partners_.size(); ++i) {
    Partner& partner = partners_[i];
    if (partner.peer == 0) continue;
    if (!partner.present && (!partner.heard || partner.stiffness <= 0)) {
      partner = Partner{};
      continue;
    }
    if (!partner.heard) continue;
    const double k = partner.stiffness;
    // the copy of a silent partner stands
    const double quiet = Seconds(now_ns - partner.heard_ns) - kQuietAfter;
    partner.moving = std::min(std::clamp(1.0 - quiet / kQuietTime, 0.0, 1.0),
                              partner.moving + kFrame / kHeardTime);
    const double b = partner.relative_damping;
    const Twist wanted{partner.moving * partner.state.V_WB.w,
                       partner.moving * partner.state.V_WB.v};
    // the damper gets the part of a frame's force change that the spring leaves
    const double room = std::max(0.0, kMostStep - partner.way_force);
    Twist& V_copy_WB = partner.V_copy_WB;
    V_copy_WB = b > 0 ? TwistTowards(V_copy_WB, wanted, room / b, per_mass) : wanted;
    // power that the damper gives, less the power that it takes
    const double given = kFrame * b *
                         ((V_copy_WB.v - own.V_WB.v).dot(own.V_WB.v) +
                          (V_copy_WB.w - own.V_WB.w).dot(per_mass * own.V_WB.w));
    if (given <= 0) {
      partner.gate.Earn(-given);
    } else if (options_.gate && given > partner.gate.tank()) {
      V_copy_WB = {};
    } else {
      partner.gate.Charge(given);
    }
    StepInputs::Link& link = inputs.links[link_count_];
    link.copy = {
        {ClampedTurn(own.X_WB.q, partner.copy_WB.q, partner.stretch.turn, partner.turn_axis),
         partner.copy_WB.p},
        V_copy_WB};
    if (Planted(Fault::kLinkSign)) link.copy.X_WA.p = 2.0 * own.X_WB.p - link.copy.X_WA.p;
    if (Planted(Fault::kLinkTurn)) {
      link.copy.X_WA.q = own.X_WB.q * link.copy.X_WA.q.conjugate() * own.X_WB.q;
    }
    link.gains = {k, b, k * per_mass, b * per_mass};
    if (options_.exchange_forces) {
      // the wire carries the force on the sender's end: the other end's is opposite to ours
      partner.computed_B_W = AsWrench(CouplingLoad(link.gains, own, Pose{}, link.copy).force);
      link.gains = {};
      link.push_B_W = {-partner.its_applied_B_W.tau, -partner.its_applied_B_W.f};
    }
    partner_of_link_[link_count_++] = i;
    stiffness_sum += k;
  }
  inputs.link_count = link_count_;
  common.te_s = DesignDelay(WorstLoopAge());
  // a link that is to rise from nothing has the least drag, which earns the cost of the rise
  const double risen = coupled() > 0 ? std::max(stiffness_sum, kNext) : stiffness_sum;
  inputs.ground_damping = options_.law->GroundDamping(common, risen);
  if (stiffness_sum > 0) {
    inputs.ground_damping = DragAfter(kFrame, ground_damping_, inputs.ground_damping);
  }
  inputs.ground_rotation_damping = inputs.ground_damping * per_mass;
  ground_damping_ = inputs.ground_damping;
}

void SharedBody::Describe(std::int64_t now_ns, std::uint32_t seq, const StepReport& report,
                          CouplingLinks& out) noexcept {
  sent_.Add(now_ns);
  out.from = self_;
  out.object = object_;
  out.seq = seq;
  out.sample_ns = now_ns;
  out.count = 0;
  for (std::size_t link = 0; link < link_count_; ++link) {
    Partner& partner = partners_[partner_of_link_[link]];
    partner.applied_B_W = report.links_B_W[link];
    if (!partner.present) continue;
    out.entries[out.count++] = {
        .to = partner.peer,
        .echo_ns = partner.state.sample_ns,
        .stiffness = partner.offered_stiffness,
        .gate_overflow = partner.gate.overflow(),
        .applied_B_W = options_.exchange_forces ? partner.computed_B_W : partner.applied_B_W};
    LinkEntry& entry = out.entries[out.count - 1];
    if (Planted(Fault::kEchoOfArrival)) entry.echo_ns = partner.heard_ns;
    if (Planted(Fault::kOwnStampForTheirs)) entry.echo_ns = partner.echo_ns;
    if (Planted(Fault::kNotFinite) && seq % 1000 == 999) entry.stiffness = std::nan("");
    if (Planted(Fault::kNegativeStiffness) && seq % 1000 == 999) entry.stiffness = -1.0;
    if (Planted(Fault::kOthersName)) out.from = partner.peer;
    if (Planted(Fault::kLinkToItself)) entry.to = self_;
  }
}

std::size_t SharedBody::Links(std::int64_t now_ns,
                              std::array<LinkView, kMaxLinks>& out) const noexcept {
  const auto size = [this](const Wrench& F) {
    return std::sqrt(F.f.squaredNorm() + F.tau.squaredNorm() / (gyration_ * gyration_));
  };
  for (std::size_t link = 0; link < link_count_; ++link) {
    const Partner& partner = partners_[partner_of_link_[link]];
    Wrench sum = partner.applied_B_W;
    sum += partner.its_applied_B_W;
    const double larger = std::max(size(partner.applied_B_W), size(partner.its_applied_B_W));
    out[link] = {.peer = partner.peer,
                 .closed = partner.closed(),
                 .loop_age_s = partner.linked ? partner.loop_age_s(now_ns) : 0.0,
                 .te_s = DesignDelay(partner.meter.peak_loop_age_s()),
                 .stiffness = partner.stiffness,
                 .force = partner.applied_B_W.f.norm(),
                 .its_force = partner.its_applied_B_W.f.norm(),
                 .tank = partner.gate.tank(),
                 .clipped = partner.gate.clipped(),
                 .disagreement = larger > 0 ? size(sum) / larger : 0.0};
  }
  return link_count_;
}

std::size_t SharedBody::coupled() const noexcept {
  return static_cast<std::size_t>(
      std::count_if(partners_.begin(), partners_.end(), [](const Partner& p) {
        return p.closed();
      }));
}

double SharedBody::delay_s(std::int64_t now_ns) const noexcept {
  double delay = 0;
  for (const Partner& partner : partners_) {
    if (!partner.present || !partner.linked) continue;
    delay = std::max(delay, 0.5 * partner.loop_age_s(now_ns));
  }
  return delay;
}

}  // namespace tandem
