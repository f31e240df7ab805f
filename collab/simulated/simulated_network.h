#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "collab/transport.h"

namespace tandem {

/// A network in virtual time for any number of peers in one thread: what one publishes reaches the
/// others at once, in the order they joined; delay, jitter and loss are the receivers'
/// conditioners, as over DDS. Viewers get views and no states, active peers states and no views.
class SimulatedNetwork {
 public:
  /// The time that arrivals are stamped with, ns.
  void SetNow(std::int64_t now_ns) noexcept { now_ns_ = now_ns; }

  /// Both the network and `inbox` must outlive the transport. A transport destroyed without Leave()
  /// is a crash: the others learn of it as a loss.
  std::unique_ptr<Transport> Join(PeerId peer, Role role, Inbox& inbox);

 private:
  class Link;
  struct Member {
    Role role;
    Inbox* inbox;
    std::optional<PeerInfo> info;  // newest, for those who come later
  };

  void Remove(PeerId peer, bool graceful);

  std::int64_t now_ns_ = 0;
  std::map<PeerId, Member> members_;
  std::optional<SceneManifest> scene_;
};

}  // namespace tandem
