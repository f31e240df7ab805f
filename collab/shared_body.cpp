#include "collab/shared_body.h"

#include <algorithm>
#include <cmath>

#include "collab/newer.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr double kFadeTime = 0.2;       // s, of a partner that is gone
constexpr double kFallTime = 0.02;      // s, of a stiffness that must fall
constexpr double kFastestRise = 400.0;  // N/m/s
constexpr double kRisePower = 0.02;     // W that a rising spring may put in
constexpr double kArmMass = 1.2;        // kg of hand and device that may move with the body

/// The next stiffness on the way to `wanted`, the spring being stretched by `stretch` (m).
double Slewed(double stiffness, double wanted, double stretch) {
  if (wanted <= stiffness) return wanted + (stiffness - wanted) * std::exp(-kFrame / kFallTime);
  const double by_power = 2.0 * kRisePower / std::max(stretch * stretch, 1e-8);
  return std::min(wanted, stiffness + kFrame * std::min(kFastestRise, by_power));
}

}  // namespace

SharedBody::SharedBody(PeerId self, ObjectId object, const Inertia& inertia, const Options& options)
    : self_(self), object_(object), inertia_(inertia), options_(options) {}

SharedBody::Partner* SharedBody::Find(PeerId peer) noexcept {
  const auto it = std::find_if(partners_.begin(), partners_.end(), [peer](const Partner& p) {
    return p.peer == peer;
  });
  return it == partners_.end() ? nullptr : &*it;
}

void SharedBody::Join(PeerId peer) noexcept {
  Partner* partner = Find(peer);
  if (partner != nullptr && partner->present) return;
  if (partner == nullptr) partner = Find(0);
  if (partner == nullptr) return;  // more users than places: it stays uncoupled
  *partner = Partner{};
  partner->peer = peer;
  partner->present = true;
}

void SharedBody::Part(PeerId peer) noexcept {
  if (Partner* partner = Find(peer)) partner->present = false;
}

void SharedBody::OnState(const ObjectState& state) noexcept {
  if (state.object != object_) return;
  Partner* partner = Find(state.peer);
  if (partner == nullptr || !partner->present) return;
  if (partner->heard && !IsNewer(state, partner->state)) return;
  partner->state = state;
  partner->heard = true;
}

void SharedBody::OnLinks(const CouplingLinks& links) noexcept {
  if (links.object != object_) return;
  Partner* partner = Find(links.from);
  if (partner == nullptr || !partner->present) return;
  if (partner->linked && !IsAfter(links.seq, partner->links_seq)) return;
  for (std::size_t i = 0; i < std::min<std::size_t>(links.count, kMaxLinks); ++i) {
    const LinkEntry& entry = links.entries[i];
    if (entry.to != self_ || entry.echo_ns == 0) continue;
    partner->echo_ns = entry.echo_ns;
    partner->its_stiffness = std::max(0.0, entry.stiffness);
    partner->links_seq = links.seq;
    partner->linked = true;
  }
}

void SharedBody::Prepare(std::int64_t now_ns, const RigidState& own, StepInputs& inputs) noexcept {
  // one delay for all links, the worst: simplest, and safe
  double peak = 0;
  for (Partner& partner : partners_) {
    if (!partner.present || !partner.heard || !partner.linked) continue;
    partner.meter.Add(now_ns, now_ns - partner.echo_ns);
    delay_sum_s_ += 0.5e-9 * static_cast<double>(now_ns - partner.echo_ns);
    ++delays_;
    peak = std::max(peak, partner.meter.peak_loop_age_s());
  }
  own_stiffness_ =
      LinkStiffness(options_.law, options_.limits, peak, coupled() + 1, inertia_.mass + kArmMass);

  const Mat3 R = own.X_WB.q.toRotationMatrix();
  const Mat3 per_mass = R * inertia_.I_B * R.transpose() / inertia_.mass;
  double stiffness_sum = 0;
  link_count_ = 0;
  for (std::size_t i = 0; i < partners_.size(); ++i) {
    Partner& partner = partners_[i];
    if (partner.peer == 0 || !partner.heard) {
      if (!partner.present) partner.peer = 0;
      continue;
    }
    if (!partner.present) {
      partner.fade -= kFrame / kFadeTime;
      if (partner.fade <= 0) {
        partner = Partner{};
        continue;
      }
    } else {
      const double stretch = (partner.state.X_WB.p - own.X_WB.p).norm();
      const double wanted = partner.linked ? std::min(own_stiffness_, partner.its_stiffness) : 0.0;
      partner.stiffness = Slewed(partner.stiffness, wanted, stretch);
    }
    const double k = partner.fade * partner.stiffness;
    StepInputs::Link& link = inputs.links[link_count_];
    link.copy = {partner.state.X_WB, {}};
    link.gains = {k, 0.0, k * per_mass, Mat3::Zero()};
    partner_of_link_[link_count_++] = i;
    stiffness_sum += k;
  }
  inputs.link_count = link_count_;
  inputs.ground_damping = LinkDrag(options_.law, options_.limits, stiffness_sum, DesignDelay(peak));
  inputs.ground_rotation_damping = inputs.ground_damping * per_mass;
}

void SharedBody::Describe(std::int64_t now_ns, std::uint32_t seq, const StepReport& report,
                          CouplingLinks& out) const noexcept {
  out.from = self_;
  out.object = object_;
  out.seq = seq;
  out.sample_ns = now_ns;
  out.count = 0;
  for (std::size_t link = 0; link < link_count_; ++link) {
    const Partner& partner = partners_[partner_of_link_[link]];
    if (!partner.present) continue;
    out.entries[out.count++] = {.to = partner.peer,
                                .echo_ns = partner.state.sample_ns,
                                .stiffness = own_stiffness_,
                                .applied_B_W = report.links_B_W[link]};
  }
}

std::size_t SharedBody::coupled() const noexcept {
  return static_cast<std::size_t>(
      std::count_if(partners_.begin(), partners_.end(), [](const Partner& p) {
        return p.present && p.heard && p.linked;
      }));
}

double SharedBody::delay_s(std::int64_t now_ns) const noexcept {
  double delay = 0;
  for (const Partner& partner : partners_) {
    if (!partner.present || !partner.linked) continue;
    delay = std::max(delay, 0.5e-9 * static_cast<double>(now_ns - partner.echo_ns));
  }
  return delay;
}

}  // namespace tandem
