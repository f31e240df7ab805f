#include "collab/peer_inbox.h"

namespace tandem {

PeerInbox::PeerInbox(const LinkConditions& conditions, PeerDirectory& directory)
    : conditioner_(conditions), directory_(&directory) {}

void PeerInbox::OnState(const ObjectState& state, std::int64_t arrival_ns) {
  const std::optional<std::int64_t> due = conditioner_.Due(arrival_ns);
  if (due && !states_.TryPush({*due, state})) overflows_.fetch_add(1, std::memory_order_relaxed);
}

void PeerInbox::OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) {
  const std::optional<std::int64_t> due = conditioner_.Due(arrival_ns);
  if (due && !links_.TryPush({*due, links})) overflows_.fetch_add(1, std::memory_order_relaxed);
}

void PeerInbox::OnEvent(const Event& event, std::int64_t) {
  if (!events_.TryPush(event)) overflows_.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace tandem
