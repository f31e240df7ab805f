#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "app/connection/connection_options.h"
#include "collab/session/transport.h"
#include "engine/base/result.h"

namespace tandem {

/// Hears only which other active peers are in the session. Nothing from there may reach the replay.
class ActivePeerInbox final : public Inbox {
 public:
  void OnState(const ObjectState&, std::int64_t) override {}
  void OnLinks(const CouplingLinks&, std::int64_t) override {}
  void OnView(const ViewFrame&, std::int64_t) override {}
  void OnPeerInfo(const PeerInfo& info, std::int64_t) override {
    if (info.role != Role::kActive) return;
    const std::lock_guard lock(mutex_);
    active_[info.peer] = info.name;
  }
  void OnPeerLeft(PeerId peer) override { Forget(peer); }
  void OnPeerLost(PeerId peer) override { Forget(peer); }
  void OnEvent(const Event&, std::int64_t) override {}
  void OnScene(const SceneManifest&) override {}

  /// Returns the name of an active peer that is here; nothing: none is.
  std::optional<std::string> Active() const {
    const std::lock_guard lock(mutex_);
    return active_.empty() ? std::nullopt : std::optional(active_.begin()->second);
  }

 private:
  void Forget(PeerId peer) {
    const std::lock_guard lock(mutex_);
    active_.erase(peer);
  }

  mutable std::mutex mutex_;
  std::map<PeerId, std::string> active_;
};

/// Returns why a replay cannot be shown beside an active peer. Such a peer would take it for one
/// that answers for bodies and is deaf.
std::string NotBeside(const std::string& name, const std::string& session);

/// Joins the viewers' session; with an empty `session` it returns a transport that sends nothing.
/// `exit_code`: code of a failure.
Result<std::unique_ptr<Transport>> JoinForViewers(const std::string& session,
                                                  const ConnectionOptions& connection,
                                                  ActivePeerInbox& active_peers, int& exit_code);

}  // namespace tandem
