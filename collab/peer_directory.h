#pragma once

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "collab/membership.h"
#include "engine/realtime/spsc_queue.h"

namespace tandem {

/// Who is in the session, as told by peer_info (paper §6.1: anyone may enter or leave at any time).
/// Told by the transport's control thread, asked by the program's main thread; changes that bear on
/// forces go to the haptic thread through a queue.
class PeerDirectory {
 public:
  enum class Presence : std::uint8_t { kHere, kLeft, kLost };

  struct Entry {
    PeerInfo info;
    Presence presence = Presence::kHere;
    std::string told_name;  // as it calls itself
    int namesake = 1;       // which of those with its name it is
    std::string refused;    // why it is not taken in: other protocol, other scene; else empty
  };

  /// `name`: our own. Others of one name get numbers: "anna (2)".
  PeerDirectory(PeerId self, std::uint64_t scene_hash, std::string name = {});

  void OnPeerInfo(const PeerInfo& info);
  void OnPeerLeft(PeerId peer) { OnGone(peer, Presence::kLeft); }
  void OnPeerLost(PeerId peer) { OnGone(peer, Presence::kLost); }

  std::vector<Entry> Entries() const;
  /// How a person is told of a peer.
  std::string NameOf(PeerId peer) const;
  /// The active peer here of that name; 0: none.
  PeerId PeerNamed(const std::string& name) const;
  /// What happened since the last call, a line each: "anna joined", "anna left", "anna is lost",
  /// "anna is back".
  std::vector<std::string> TakeNews();
  /// The haptic thread's end.
  SpscQueue<MembershipChange>& changes() noexcept { return changes_; }

 private:
  int NumberOfNamesake(const PeerInfo& info) const;
  void OnGone(PeerId peer, Presence presence);
  void Tell(const Entry& entry, MembershipChange::Kind kind);

  PeerId self_;
  std::uint64_t scene_hash_;
  std::string name_;
  mutable std::mutex mutex_;
  std::map<PeerId, Entry> entries_;
  std::vector<std::string> news_;
  SpscQueue<MembershipChange> changes_{256};
};

}  // namespace tandem
