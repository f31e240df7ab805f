#include "collab/coupling/shared_body.h"

#include <algorithm>
#include <cmath>

#include "collab/coupling/stiffness_limiter.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr double kArmMass = 1.2;  // kg; hand and device that may move with the body
constexpr double kForgetting = 1.0 - kFrame / 120;  // factor of a frame on the longest loop age
constexpr double kNext = 1e-9;                      // N/m; sum of links that are to rise from 0

}  // namespace

SharedBody::SharedBody(PeerId self, ObjectId object, const Inertia& inertia, const Options& options)
    : self_(self),
      object_(object),
      inertia_(inertia),
      gyration_(std::sqrt(0.5 * inertia.I_B.trace() / inertia.mass)),
      options_(options) {}

bool SharedBody::Join(PeerId peer) noexcept {
  Coupled* const coupled = links_.FindOrInsert(peer);
  if (coupled != nullptr) coupled->link.Rejoin();
  return coupled != nullptr;
}

void SharedBody::Part(PeerId peer) noexcept {
  if (Coupled* const coupled = links_.Find(peer)) coupled->link.Part();
}

void SharedBody::OnState(const ObjectState& state) noexcept {
  if (state.object != object_) return;
  if (Coupled* const coupled = links_.Find(state.peer)) coupled->link.OnState(state);
}

void SharedBody::OnLinks(const CouplingLinks& links) noexcept {
  if (links.object != object_) return;
  Coupled* const coupled = links_.Find(links.from);
  if (coupled != nullptr) bad_echoes_ += coupled->link.OnLinks(links, self_, sent_);
}

std::size_t SharedBody::Instances(std::array<InstanceView, kMaxLinks>& out) const noexcept {
  std::size_t count = 0;
  for (const auto& [peer, link] : links_) {
    const bool here = link.state() != CouplingLink::State::kFading;
    if (here && link.received()) out[count++] = {peer, link.newest()->X_WB};
  }
  return count;
}

void SharedBody::CapForce(PeerId peer, double newtons) noexcept {
  if (Coupled* const coupled = links_.Find(peer)) coupled->link.CapForce(newtons);
}

void SharedBody::FadeForce(PeerId peer, double share) noexcept {
  if (Coupled* const coupled = links_.Find(peer)) coupled->link.FadeForce(share);
}

double SharedBody::WorstLoopAge() const noexcept {
  double worst = 0;
  for (const auto& [peer, link] : links_) {
    if (link.closed()) worst = std::max(worst, link.peak_loop_age_s());
  }
  return worst;
}

LawInputs SharedBody::MeasureDelays(std::int64_t now_ns) noexcept {
  double peak = 0;
  std::size_t users = 1;
  longest_loop_age_s_ *= kForgetting;
  for (auto& [peer, link] : links_) {
    link.Measure(now_ns, last_frame_ns_);
    if (!link.closed()) continue;
    longest_loop_age_s_ = std::max(longest_loop_age_s_, link.peak_loop_age_s());
    delay_sum_s_ += 0.5 * link.loop_age_s(now_ns);
    ++delays_;
    ++users;
    peak = std::max(peak, std::min(link.peak_loop_age_s(), kLongestCommonLoop));
  }
  last_frame_ns_ = now_ns;
  return LawInputsAt(peak, users, inertia_.mass + kArmMass);
}

void SharedBody::MoveCopies(const LinkFrame& frame) noexcept {
  double sum = 0;
  for (const auto& [peer, link] : links_) sum += link.stiffness();
  const Twist& V_WB = frame.own.V_WB;
  const double lost =
      kFrame * ground_damping_ * (V_WB.v.squaredNorm() + V_WB.w.dot(frame.per_mass * V_WB.w));
  const auto closed = static_cast<double>(coupled());
  for (auto& [peer, link] : links_) {
    if (!link.received()) continue;
    if (sum > 0) {
      link.Earn(lost * link.stiffness() / sum);
    } else if (link.closed()) {
      link.Earn(lost / closed);
    }
    link.MoveCopy(frame);
  }
}

void SharedBody::Slew(const LinkFrame& frame, const LawInputs& common) noexcept {
  SharedStiffness shared{.law = *options_.law,
                         .common = common,
                         .allowed = options_.law->Link(common),
                         .longest_loop_age_s = longest_loop_age_s_};
  shared.most = shared.allowed.stiffness * static_cast<double>(common.users - 1);
  double falling = 0;
  double rising = 0;
  for (const auto& [peer, link] : links_) {
    if (link.closed()) shared.sum += link.stiffness();
    if (link.state() == CouplingLink::State::kRising) shared.has_newcomer = true;
    if (link.falls()) ++falling;
    if (link.rises()) ++rising;
  }
  shared.falls_share = 1.0 / std::max(1.0, falling);
  shared.rises_share = 1.0 / std::max(1.0, rising);
  for (auto& [peer, link] : links_) {
    if (link.received()) link.Slew(frame, shared);
  }
}

double SharedBody::Couple(const LinkFrame& frame, StepInputs& inputs) noexcept {
  double stiffness_sum = 0;
  link_count_ = 0;
  for (Coupled& coupled : links_) {
    if (coupled.link.over()) {
      links_.Erase(coupled.peer);
      continue;
    }
    if (!coupled.link.received()) continue;
    coupled.link.Couple(frame, inputs.links[link_count_]);
    slots_[link_count_++] = links_.SlotOf(coupled);
    stiffness_sum += coupled.link.stiffness();
  }
  inputs.link_count = link_count_;
  return stiffness_sum;
}

void SharedBody::SetDrag(LawInputs common, double stiffness_sum, const Mat3& per_mass,
                         StepInputs& inputs) noexcept {
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

void SharedBody::Prepare(std::int64_t now_ns, const RigidState& own, StepInputs& inputs) noexcept {
  const Mat3 R = own.X_WB.q.toRotationMatrix();
  const Mat3 per_mass = R * inertia_.I_B * R.transpose() / inertia_.mass;
  const LinkFrame frame{
      .now_ns = now_ns, .own = own, .per_mass = per_mass, .experiments = options_.experiments};
  const LawInputs common = MeasureDelays(now_ns);
  MoveCopies(frame);
  Slew(frame, common);
  const double stiffness_sum = Couple(frame, inputs);
  SetDrag(common, stiffness_sum, per_mass, inputs);
}

void SharedBody::Describe(std::int64_t now_ns, std::uint32_t seq, const StepReport& report,
                          CouplingLinks& out) noexcept {
  sent_.Add(now_ns);
  out.from = self_;
  out.object = object_;
  out.seq = seq;
  out.sample_ns = now_ns;
  out.count = 0;
  for (std::size_t i = 0; i < link_count_; ++i) {
    auto& [peer, link] = *links_.InSlot(slots_[i]);
    link.NoteApplied(report.links_B_W[i]);
    if (link.state() == CouplingLink::State::kFading) continue;
    out.entries[out.count++] = link.Describe(peer);
  }
}

std::size_t SharedBody::Links(std::int64_t now_ns,
                              std::array<LinkView, kMaxLinks>& out) const noexcept {
  for (std::size_t i = 0; i < link_count_; ++i) {
    const auto& [peer, link] = *links_.InSlot(slots_[i]);
    out[i] = link.View(peer, now_ns, gyration_);
  }
  return link_count_;
}

std::size_t SharedBody::coupled() const noexcept {
  return static_cast<std::size_t>(std::ranges::count_if(links_, [](const Coupled& coupled) {
    return coupled.link.closed();
  }));
}

double SharedBody::delay_s(std::int64_t now_ns) const noexcept {
  double delay = 0;
  for (const auto& [peer, link] : links_) {
    if (link.state() == CouplingLink::State::kFading) continue;
    delay = std::max(delay, 0.5 * link.loop_age_s(now_ns));
  }
  return delay;
}

}  // namespace tandem
