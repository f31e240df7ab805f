#include "collab/ownership/ownership.h"

#include <algorithm>

#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr std::int64_t kNextTouch = 20 * kMs;  // for all bodies: more would count as a flood
constexpr std::int64_t kGiveUp = 5000 * kMs;
constexpr std::int64_t kPause = 500 * kMs;   // a longer gap between our own frames: we were stopped
constexpr std::int64_t kListen = 300 * kMs;  // listening after a pause

}  // namespace

Ownership::Ownership(PeerId self, const WorldModel& model, std::int64_t settle_ns, bool own_only,
                     DropTable* drops)
    : self_(self), settle_ns_(settle_ns), own_only_(own_only), drops_(drops) {
  for (std::size_t b = 0; b < model.object.size(); ++b) {
    Body& body = bodies_.emplace_back();
    body.index = b;
    body.object = model.object[b];
    body.shared = model.scene.bodies[body.object].shared;
    body.free = model.scene.bodies[body.object].free;
    body.X_WB = model.bodies[b].X_WB0;
  }
  to_send_.resize(2 * bodies_.size() + 16);
}

int Ownership::BodyOf(ObjectId object) const noexcept {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].object == object) return static_cast<int>(b);
  }
  return -1;
}

const Claim* Ownership::ClaimOf(const Member& member, std::size_t body) noexcept {
  return body < kMaxClaims && member.claims[body] ? &*member.claims[body] : nullptr;
}

bool Ownership::HeldBy(std::size_t body, PeerId peer) const noexcept {
  if (peer == self_) return held_ == static_cast<int>(body);
  const Member* member = members_.Find(peer);
  if (member == nullptr || !member->present) return false;
  const Claim* claim = ClaimOf(*member, body);
  return claim != nullptr && claim->held;
}

std::size_t Ownership::Holders(std::size_t body,
                               std::array<PeerId, kMaxPeers>& out) const noexcept {
  std::size_t count = 0;
  for (const Member& member : members_) {
    if (HeldBy(body, member.peer)) out[count++] = member.peer;
  }
  return count;
}

bool Ownership::HeldByOther(std::size_t body) const noexcept {
  return LowestOther(static_cast<int>(body)) != 0;
}

PeerId Ownership::LowestOther(int holding_body) const noexcept {
  PeerId lowest = 0;
  for (const Member& member : members_) {
    if (!member.present || (lowest != 0 && member.peer > lowest)) continue;
    if (holding_body >= 0 && !HeldBy(static_cast<std::size_t>(holding_body), member.peer)) continue;
    lowest = member.peer;
  }
  return lowest;
}

PeerId Ownership::authority(std::size_t body) const noexcept {
  if (bodies_[body].claim.peer != 0) return bodies_[body].claim.peer;
  const PeerId other = LowestOther(-1);
  return other != 0 && other < self_ ? other : self_;
}

bool Ownership::Parks(std::size_t body) const noexcept {
  return bodies_[body].claim.peer == self_ && held_ != static_cast<int>(body) &&
         !(bodies_[body].shared && HeldByOther(body));
}

const Pose* Ownership::ParkedAt(std::size_t body) const noexcept {
  const Body& b = bodies_[body];
  return b.reported ? &b.parked : nullptr;
}

bool Ownership::Greater(std::uint32_t epoch, PeerId peer, const Body& than) noexcept {
  if (than.claim.peer == 0) return true;
  return epoch > than.claim.epoch || (epoch == than.claim.epoch && peer < than.claim.peer);
}

bool Ownership::Accepts(const ObjectState& state) const noexcept {
  const int found = BodyOf(state.object);
  if (found < 0) return false;
  const Body& body = bodies_[static_cast<std::size_t>(found)];
  const bool answers =
      body.claim.peer == state.peer && body.claim.epoch == state.epoch && !body.forsaken;
  if ((state.flags & kStateLoose) != 0) return answers && body.free;
  if (!body.shared || (state.flags & kStateParked) != 0) return answers;
  return HeldBy(static_cast<std::size_t>(found), state.peer);
}

void Ownership::Ask(ObjectId object) noexcept {
  const int found = BodyOf(object);
  if (found < 0 || found == held_) return;
  if (own_only_ && bodies_[static_cast<std::size_t>(found)].shared) return;
  if (stopped_) return Notify(Notification::Kind::kStopped, static_cast<std::size_t>(found), 0);
  Release();
  bodies_[static_cast<std::size_t>(found)].withdrawn_ns = 0;
  wanted_ = found;
  wanted_since_ns_ = now_ns_;
  asked_ns_ = 0;
}

void Ownership::Release() noexcept {
  if (wanted_ >= 0 && asked_ns_ != 0) {
    bodies_[static_cast<std::size_t>(wanted_)].withdrawn_ns = now_ns_;
  }
  wanted_ = -1;
  if (held_ < 0) return;
  const auto index = static_cast<std::size_t>(held_);
  Body& body = bodies_[index];
  held_ = -1;
  body.reported = false;
  Notify(Notification::Kind::kLetGo, index, 0);
  const PeerId next = body.shared ? LowestOther(static_cast<int>(index)) : 0;
  if (body.claim.peer == self_ && next != 0) {
    HandOver(index, EventKind::kRelease, next);
  } else if (body.claim.peer == self_) {
    QueueEvent(EventKind::kRelease, index, body.claim.epoch, 0);
  } else if (next == 0 && (!IsHere(body.claim.peer) || body.forsaken)) {
    // ours is the last hand on a shared body whose authority is gone
    NoteBefore(body, body.forsaken);
    body.claim = {Next(body.claim.epoch), self_};
    body.began_epoch = body.claim.epoch;
    body.claimed_ns = now_ns_;
    body.forsaken = false;
    body.by_word = false;
  }
}

void Ownership::NoteTouch(std::size_t index) noexcept {
  Body& body = bodies_[index];
  if (!body.free) return;
  body.touched_ns = now_ns_;
  const PeerId answers = authority(index);
  if (answers == self_ || listening() || HeldByOther(index)) return;
  if (body.touch_sent_ns != 0 && now_ns_ - body.touch_sent_ns < kAskAgain) return;
  if (touch_sent_ns_ != 0 && now_ns_ - touch_sent_ns_ < kNextTouch) return;
  body.touch_sent_ns = touch_sent_ns_ = now_ns_;
  QueueEvent(EventKind::kTouch, index, body.claim.epoch, answers);
}

void Ownership::Stop() noexcept {
  stopped_ = true;
  Release();
}

void Ownership::Give(PeerId to) noexcept {
  if (held_ < 0 || to == self_ || listening()) return;
  const auto index = static_cast<std::size_t>(held_);
  const Member* member = members_.Find(to);
  if (member == nullptr || !member->present || bodies_[index].claim.peer != self_) return;
  held_ = -1;
  wanted_ = -1;
  Notify(Notification::Kind::kGiven, index, to);
  HandOver(index, EventKind::kGrant, to);
}

void Ownership::Leave() noexcept {
  if (held_ >= 0) Release();
  wanted_ = -1;
  const PeerId next = LowestOther(-1);
  if (next == 0) return;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].claim.peer == self_) HandOver(b, EventKind::kRelease, next);
  }
}

void Ownership::TakeInHand(std::size_t index) noexcept {
  held_ = static_cast<int>(index);
  wanted_ = -1;
  for (Member& member : members_) {
    member.held_before = HeldBy(index, member.peer) ? held_ : -1;
  }
  // beside other holders our claim has their epoch; the lowest holder is the authority
  Body& body = bodies_[index];
  // unless we have claimed a later epoch: ours never falls
  hold_epoch_ = std::max(body.claim.epoch, body.last_epoch);
  if (body.shared && self_ < body.claim.peer && hold_epoch_ == body.claim.epoch) {
    NoteBefore(body, true);
    body.claim.peer = self_;
    body.claimed_ns = now_ns_;
    body.forsaken = false;
  }
  Notify(Notification::Kind::kInHand, index, 0);
}

void Ownership::Begin(std::int64_t now_ns) noexcept {
  if (now_ns_ == 0) {
    listen_until_ns_ = now_ns + settle_ns_;
    first_ns_ = now_ns;
    for (Member& member : members_) member.known_ns = member.since_ns = now_ns;
  } else if (now_ns - now_ns_ > kPause) {
    listen_until_ns_ = std::max(listen_until_ns_, now_ns + kListen);
    // the others heard nothing meanwhile, so the pause does not count as waiting
    wanted_since_ns_ += now_ns - now_ns_;
    paused_ns_ = now_ns;
  }
  now_ns_ = now_ns;
}

void Ownership::Tick(std::int64_t now_ns, std::span<Event> out, std::size_t& count) noexcept {
  Begin(now_ns);
  Settle();
  if (wanted_ >= 0) RepeatRequests();
  if (!listening()) Succeed();

  count = std::min(out.size(), send_count_);
  for (std::size_t i = 0; i < count; ++i) {
    out[i] = to_send_[send_first_];
    send_first_ = (send_first_ + 1) % to_send_.size();
  }
  send_count_ -= count;
}

void Ownership::RepeatRequests() noexcept {
  const auto index = static_cast<std::size_t>(wanted_);
  Body& body = bodies_[index];
  if (wanted_since_ns_ == 0) wanted_since_ns_ = now_ns_;
  if (listening()) {
    wanted_since_ns_ = now_ns_;
    return;
  }
  if (body.shared && HeldByOther(index)) {
    TakeInHand(index);
    return;
  }
  const PeerId answers = authority(index);
  if (answers == self_) {
    if (body.claim.peer == 0) {
      body.claim = {1, self_};
      body.began_epoch = 1;
      body.claimed_ns = now_ns_;
    }
    if (!IsInAnothersHand(index)) return TakeInHand(index);
    if (now_ns_ - wanted_since_ns_ <= kGiveUp) return;
    wanted_ = -1;
    return Notify(Notification::Kind::kNoAnswer, index, answers);
  }
  if (now_ns_ - wanted_since_ns_ > kGiveUp) {
    wanted_ = -1;
    Notify(Notification::Kind::kNoAnswer, index, answers);
    return;
  }
  if (asked_ns_ != 0 && now_ns_ - asked_ns_ < kAskAgain) return;
  if (asked_ns_ == 0) Notify(Notification::Kind::kAsking, index, answers);
  asked_ns_ = now_ns_;
  requested_ = answers;
  QueueEvent(EventKind::kAsk, index, body.claim.epoch, answers);
}

std::uint32_t Ownership::Claims(std::array<Claim, kMaxClaims>& out) const noexcept {
  std::uint32_t count = 0;
  const auto add = [&](std::size_t b) {
    const bool answers = bodies_[b].claim.peer == self_;
    const bool in_hand = held_ == static_cast<int>(b);
    if (count == kMaxClaims || (!answers && !in_hand)) return;
    out[count++] = {bodies_[b].object, own_epoch(b), in_hand};
  };
  if (held_ >= 0) add(static_cast<std::size_t>(held_));
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (held_ != static_cast<int>(b)) add(b);
  }
  return count;
}

std::uint32_t Ownership::Beliefs(std::array<Belief, kMaxClaims>& out) const noexcept {
  std::uint32_t count = 0;
  for (const Body& body : bodies_) {
    if (body.claim.peer == 0 || body.claim.peer == self_ || count == kMaxClaims) continue;
    out[count++] = {body.object, body.claim.peer, body.claim.epoch};
  }
  return count;
}

void Ownership::RequestReunion() noexcept {
  if (held_ < 0) return;
  const auto body = static_cast<std::size_t>(held_);
  QueueEvent(EventKind::kHeal, body, bodies_[body].claim.epoch, 0);
}

void Ownership::QueueEvent(EventKind kind, std::size_t index, std::uint32_t epoch,
                           PeerId to) noexcept {
  if (send_count_ == to_send_.size()) return;  // the request will be repeated
  Event& event = to_send_[(send_first_ + send_count_++) % to_send_.size()];
  event = {.peer = self_,
           .seq = ++event_seq_,
           .kind = kind,
           .object = bodies_[index].object,
           .epoch = epoch,
           .to = to,
           .X_WB = bodies_[index].X_WB};
}

void Ownership::Notify(Notification::Kind kind, std::size_t index, PeerId peer) noexcept {
  if (news_count_ < notifications_.size())
    notifications_[news_count_++] = {kind, bodies_[index].object, peer};
}

bool Ownership::TakeNotifications(Notification& notification) noexcept {
  if (news_count_ == 0) return false;
  notification = notifications_[0];
  std::copy(notifications_.begin() + 1,
            notifications_.begin() + static_cast<std::ptrdiff_t>(news_count_),
            notifications_.begin());
  --news_count_;
  return true;
}

}  // namespace tandem
