#include "collab/session/early_inbox.h"

#include "engine/base/check.h"

namespace tandem {

std::optional<SceneManifest> EarlyInbox::SessionScene() const {
  const std::lock_guard lock(mutex_);
  const SceneManifest* const session = offers_.session();
  return session == nullptr ? std::nullopt : std::optional(*session);
}

bool EarlyInbox::HasPeers() const {
  const std::scoped_lock lock(mutex_);
  return !here_.empty();
}

std::string EarlyInbox::NameOf(PeerId peer) const {
  const std::lock_guard lock(mutex_);
  const auto known = here_.find(peer);
  return known == here_.end() ? "" : known->second.info.name;
}

void EarlyInbox::HandOver(Inbox& inbox) {
  const std::lock_guard lock(mutex_);
  TANDEM_CHECK(next_.load() == nullptr);
  for (const auto& [peer, received] : here_) inbox.OnPeerInfo(received.info, received.arrival_ns);
  for (const SceneManifest& manifest : offers_.All()) inbox.OnScene(manifest);
  here_.clear();
  next_.store(&inbox);
}

void EarlyInbox::OnState(const ObjectState& state, std::int64_t arrival_ns) {
  if (Inbox* const next = next_.load()) next->OnState(state, arrival_ns);
}

void EarlyInbox::OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) {
  if (Inbox* const next = next_.load()) next->OnLinks(links, arrival_ns);
}

void EarlyInbox::OnView(const ViewFrame& frame, std::int64_t arrival_ns) {
  if (Inbox* const next = next_.load()) next->OnView(frame, arrival_ns);
}

void EarlyInbox::OnDropped(PeerId from, Drop reason) {
  if (Inbox* const next = next_.load()) next->OnDropped(from, reason);
}

void EarlyInbox::OnEvent(const Event& event, std::int64_t arrival_ns) {
  if (Inbox* const next = next_.load()) next->OnEvent(event, arrival_ns);
}

void EarlyInbox::OnPeerInfo(const PeerInfo& info, std::int64_t arrival_ns) {
  const std::lock_guard lock(mutex_);
  if (Inbox* const next = next_.load()) {
    next->OnPeerInfo(info, arrival_ns);
    return;
  }
  offers_.OnPresence(info.peer, true);
  if (here_.size() < kMost || here_.count(info.peer) != 0) here_[info.peer] = {info, arrival_ns};
}

void EarlyInbox::OnPeerLeft(PeerId peer) {
  const std::lock_guard lock(mutex_);
  if (Inbox* const next = next_.load()) {
    next->OnPeerLeft(peer);
  } else {
    Forget(peer);
  }
}

void EarlyInbox::OnPeerLost(PeerId peer) {
  const std::lock_guard lock(mutex_);
  if (Inbox* const next = next_.load()) {
    next->OnPeerLost(peer);
  } else {
    Forget(peer);
  }
}

void EarlyInbox::OnScene(const SceneManifest& manifest) {
  const std::lock_guard lock(mutex_);
  if (Inbox* const next = next_.load()) {
    next->OnScene(manifest);
  } else {
    offers_.OnScene(manifest);
  }
}

void EarlyInbox::OnSceneWithdrawn(PeerId peer) {
  const std::lock_guard lock(mutex_);
  if (Inbox* const next = next_.load()) {
    next->OnSceneWithdrawn(peer);
  } else {
    offers_.OnWithdrawn(peer);
  }
}

void EarlyInbox::OnTwin(const PeerInfo& info) {
  twin_ = true;
  if (Inbox* const next = next_.load()) next->OnTwin(info);
}

void EarlyInbox::Forget(PeerId peer) {
  here_.erase(peer);
  offers_.OnPresence(peer, false);
}

}  // namespace tandem
