#include "collab/receive/peer_inbox.h"

#include <algorithm>
#include <array>
#include <type_traits>

namespace tandem {

namespace {

PeerId AuthorOf(const ObjectState& state) {
  return state.peer;
}
PeerId AuthorOf(const CouplingLinks& links) {
  return links.from;
}

}  // namespace

PeerInbox::PeerInbox(const LinkConditions& conditions, PeerDirectory& directory,
                     std::size_t waiting)
    : conditions_(conditions),
      directory_(&directory),
      arriving_states_(std::min(waiting, kArriving)),
      arriving_links_(std::min(waiting, kArriving)),
      waiting_states_(waiting),
      waiting_links_(waiting) {}

void PeerInbox::OnState(const ObjectState& state, std::int64_t arrival_ns) {
  delivery_.Add(state.peer, state.seq);
  Arrive(state.peer, state, arrival_ns, arriving_states_);
}

void PeerInbox::OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) {
  Arrive(links.from, links, arrival_ns, arriving_links_);
}

template <typename T>
void PeerInbox::Arrive(PeerId from, const T& sample, std::int64_t arrival_ns,
                       SpscQueue<DueSample<T>>& ring) noexcept {
  if (from == 0) return;  // no peer has this number
  TakeSwitches();
  std::array<std::int64_t, 2> due_ns{};
  Sender& sender = SenderOf(from, arrival_ns);
  const std::size_t copies = sender.conditioner.Due(arrival_ns, due_ns);
  for (std::size_t copy = 0; copy < copies; ++copy) {
    DueSample<T>* const room = HasShare(sender) ? ring.Room() : nullptr;
    if (room == nullptr) {
      drops_.Count(from, Drop::kRingFull);
      continue;
    }
    room->due_ns = due_ns[copy];
    CopyUsed(room->sample, sample);
    ring.Push();
  }
}

bool PeerInbox::HasShare(Sender& sender) const noexcept {
  const std::uint64_t collects = collects_.load(std::memory_order_relaxed);
  if (sender.collects != collects) {
    sender.collects = collects;
    sender.brought = 0;
  }
  return sender.brought++ < kShare;
}

PeerInbox::Sender& PeerInbox::SenderOf(PeerId from, std::int64_t arrival_ns) noexcept {
  Sender* sender = senders_.Find(from);
  if (sender == nullptr) {
    sender = &PlaceFor(from);
    sender->conditioner = LinkConditioner(conditions_, from);
  }
  sender->received_ns = arrival_ns;
  return *sender;
}

PeerInbox::Sender& PeerInbox::PlaceFor(PeerId from) noexcept {
  if (Sender* const place = senders_.FindOrInsert(from)) return *place;
  // the new sender goes on with the share that is used up: another name brings no new share
  const auto silent = std::ranges::min_element(senders_, {}, &Sender::received_ns);
  const std::uint64_t collects = silent->collects;
  const std::size_t brought = silent->brought;
  senders_.Erase(silent->peer);
  Sender& place = *senders_.FindOrInsert(from);
  place.collects = collects;
  place.brought = brought;
  return place;
}

void PeerInbox::TakeSwitches() noexcept {
  LinkSwitch order;
  while (switches_.TryPop(order)) {
    if (order.from != 0) {
      SenderOf(order.from, 0).conditioner.Switch(order.conditions);
      continue;
    }
    conditions_ = order.conditions;
    for (Sender& sender : senders_) sender.conditioner.Switch(order.conditions);
  }
}

void PeerInbox::Collect() noexcept {
  collects_.store(collects_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  Move(arriving_states_, waiting_states_);
  Move(arriving_links_, waiting_links_);
}

template <typename T>
void PeerInbox::Move(SpscQueue<DueSample<T>>& ring, DueQueue<T>& waiting) noexcept {
  while (const DueSample<T>* next = ring.Front()) {
    if (!waiting.Push(next->due_ns, next->sample))
      drops_.Count(AuthorOf(next->sample), Drop::kRingFull);
    ring.Drop();
  }
}

void PeerInbox::OnEvent(const Event& event, std::int64_t) {
  if (!events_.TryPush(event)) drops_.Count(event.peer, Drop::kRingFull);
}

}  // namespace tandem
