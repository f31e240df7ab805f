#include "collab/receive/peer_inbox.h"

#include <algorithm>

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
  // where all places are taken, the sender that has been silent longest gives way
  Sender* place = &senders_[0];
  for (Sender& sender : senders_) {
    if (sender.peer == from) {
      place = &sender;
      break;
    }
    if (place->peer == 0) continue;
    if (sender.peer == 0 || sender.heard_ns < place->heard_ns) place = &sender;
  }
  if (place->peer != from) {
    place->peer = from;
    place->conditioner = LinkConditioner(conditions_, from);
  }
  place->heard_ns = arrival_ns;
  return *place;
}

void PeerInbox::TakeSwitches() noexcept {
  LinkSwitch order;
  while (switches_.TryPop(order)) {
    if (order.from != 0) {
      SenderOf(order.from, 0).conditioner.Switch(order.conditions);
      continue;
    }
    conditions_ = order.conditions;
    for (Sender& sender : senders_) {
      if (sender.peer != 0) sender.conditioner.Switch(order.conditions);
    }
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
