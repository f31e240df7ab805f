#include "collab/coupling/round_trip_tracker.h"

#include <algorithm>
#include <utility>

#include "collab/receive/newer.h"
#include "engine/base/units.h"

namespace tandem {

namespace {
constexpr std::int64_t kStillNew = 1'000'000'000;    // ns; a stamp is echoed for this long
constexpr std::int64_t kStillKnown = 2'000'000'000;  // ns; a loop's peak is kept this long after it

}  // namespace

void RoundTripTracker::OnMembership(const MembershipChange& change) noexcept {
  if (!change.present()) return others_.Erase(change.peer);
  Other* const other = others_.FindOrInsert(change.peer);
  if (other == nullptr) return;
  const auto claims = std::span(change.claims).first(change.claim_count);
  other->holds = std::ranges::any_of(claims, &Claim::held);
}

void RoundTripTracker::OnState(const ObjectState& state) noexcept {
  // states at five a second tell nothing of the delay, and a peer that holds nothing gets no echoes
  if ((state.flags & (kStateParked | kStateLoose)) != 0) return;
  Other* const other = others_.Find(state.peer);
  if (other == nullptr) return;
  other->sample_ns = std::max(other->sample_ns, state.sample_ns);
  other->received = true;
}

void RoundTripTracker::OnLinks(const CouplingLinks& links) noexcept {
  Other* const other = others_.Find(links.from);
  if (other == nullptr || other->since_ns == 0) return;
  if (other->echo_ns != 0 && !IsAfter(links.seq, other->seq)) return;
  for (std::size_t i = 0; i < std::min<std::size_t>(links.count, kMaxLinks); ++i) {
    const LinkEntry& entry = links.entries[i];
    if (entry.to != self_ || entry.echo_ns < other->echo_ns || !sent_.Has(entry.echo_ns)) continue;
    other->echo_ns = entry.echo_ns;
    other->seq = links.seq;
  }
}

RoundTripTracker::Loop RoundTripTracker::LoopTo(Other& other, std::int64_t now_ns,
                                                bool holding) noexcept {
  if (std::exchange(other.received, false)) other.received_ns = now_ns;
  Loop loop{.peer = other.peer};
  if (other.received_ns != 0) loop.received_s = ToSeconds(now_ns - other.received_ns);
  if (!holding || !other.holds) {
    other.since_ns = 0;
    other.echo_ns = 0;
    if (now_ns - other.ended_ns > kStillKnown) other.meter.Clear();
    return loop;
  }
  if (other.since_ns == 0) other.since_ns = now_ns;
  other.ended_ns = now_ns;
  loop.peak_s = other.meter.peak_loop_age_s();
  if (other.echo_ns == 0) {
    loop.peak_s = std::max(loop.peak_s, ToSeconds(now_ns - other.since_ns));
    return loop;
  }
  other.meter.Add(now_ns, now_ns - other.echo_ns);
  loop.age_s = ToSeconds(now_ns - other.echo_ns);
  loop.peak_s = other.meter.peak_loop_age_s();
  return loop;
}

void RoundTripTracker::Measure(std::int64_t now_ns, bool holding) noexcept {
  if (!holding) sent_.Clear();  // an echo from an earlier grasp is as old as the pause
  loop_count_ = 0;
  for (Other& other : others_) loops_[loop_count_++] = LoopTo(other, now_ns, holding);
}

void RoundTripTracker::Append(std::int64_t now_ns, CouplingLinks& out) noexcept {
  sent_.Add(now_ns);
  // where more peers are here than fit, they take turns
  ++turn_;
  for (std::size_t i = 0; i < others_.capacity() && out.count < kMaxLinks; ++i) {
    const Other* const other = others_.InSlot((i + turn_) % others_.capacity());
    if (other == nullptr || other->sample_ns == 0) continue;
    if (now_ns - other->received_ns > kStillNew) continue;
    const auto* end = out.entries.begin() + out.count;
    const bool named = std::any_of(static_cast<const LinkEntry*>(out.entries.begin()), end,
                                   [other](const LinkEntry& entry) {
                                     return entry.to == other->peer;
                                   });
    if (named) continue;
    out.entries[out.count] = LinkEntry{};
    out.entries[out.count].to = other->peer;
    out.entries[out.count++].echo_ns = other->sample_ns;
  }
}

}  // namespace tandem
