#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "collab/drop_counts.h"
#include "collab/membership.h"
#include "collab/scene_agreement.h"
#include "engine/realtime/spsc_queue.h"

namespace tandem {

/// What of our own scene bears on how others are met.
struct OwnTerms {
  ForceParameters parameters;
  double heaviest_kg = 0;        // of the moving bodies
  std::vector<ObjectId> shared;  // bodies that several may hold
};

/// Who is in the session, as told by peer_info (paper §6.1: anyone may enter or leave at any time).
/// Told by the transport's control thread, asked by the program's main thread; changes that bear on
/// forces go to the haptic thread through a queue. Who goes by other force parameters is met, but
/// what it holds of shared bodies is not heard of. However many come and go, at most kMost are
/// kept, and of active ones at most kMaxPeers - 1 taken in: who comes then is when one has gone.
class PeerDirectory {
 public:
  /// Those here beyond it are not taken in; of those gone the ones longest gone are forgotten.
  static constexpr std::size_t kMost = 128;
  /// Lines that may wait to be taken.
  static constexpr std::size_t kMostNews = 256;
  /// Lines on what was refused, of all: invented peers may be many.
  static constexpr std::size_t kMostRefusals = 64;

  enum class Presence : std::uint8_t { kHere, kLeft, kLost };

  struct Entry {
    PeerInfo info;
    Presence presence = Presence::kHere;
    std::string told_name;  // as it calls itself
    int namesake = 1;       // which of those with its name it is
    std::string refused;    // why it is not taken in: other protocol or scene, no place; else empty
    bool unequal = false;   // goes by other force parameters
    bool felt = false;      // the haptic thread has been told that it is here, or is to be told
    bool reached = false;   // the haptic thread has got a change by which the peer is here
    // changes that wait for room in the queue to the haptic thread; the end goes first
    std::optional<MembershipChange::Kind> owed_end;
    std::optional<MembershipChange::Kind> owed_here;
    std::uint64_t gone = 0;  // which departure it was; of those who are not here
    bool unequal_told = false;
    std::string terms_told;  // how its force terms differ from ours, as last said
  };

  /// `name`: our own. Others of one name get numbers: "anna (2)".
  PeerDirectory(PeerId self, std::uint64_t scene_hash, std::string name = {}, OwnTerms terms = {});

  void OnPeerInfo(const PeerInfo& info);
  void OnPeerLeft(PeerId peer) { OnGone(peer, Presence::kLeft); }
  void OnPeerLost(PeerId peer) { OnGone(peer, Presence::kLost); }
  void OnScene(const SceneManifest& manifest);
  void OnSceneWithdrawn(PeerId peer);
  /// Our keys are in use by another program.
  void OnTwin(const PeerInfo& info);
  /// Our own force terms, which the others' are compared with; whenever they change.
  void SetOwnTerms(const ForceTerms& terms);
  /// Tells the haptic thread what found no room in its queue, as far as there is some now.
  void TellOwed();
  /// Tells in words what was refused of whom, each once.
  void TellRefusals(const DropTable& drops);
  /// Whether the other program with our keys was here before us, as its beat tells beside ours.
  bool TwinCameBefore(std::uint32_t beat) const;

  std::vector<Entry> Entries() const;
  /// How a person is told of a peer.
  std::string NameOf(PeerId peer) const;
  /// How many active peers of our scene were here before us, as their beats tell beside our own
  /// `beat`; of those who came with us, the ones of lower id.
  std::size_t CameBefore(std::uint32_t beat) const;
  /// The active peer here of that name; 0: none.
  PeerId PeerNamed(const std::string& name) const;
  /// What the session is about, as others offer it; nothing: nobody has.
  std::optional<SceneManifest> SessionScene() const;
  /// What happened since the last call, a line each: "anna joined", "anna left", "anna is lost",
  /// "anna is back".
  std::vector<std::string> TakeNews();
  /// The haptic thread's end.
  SpscQueue<MembershipChange>& changes() noexcept { return changes_; }

 private:
  int NumberOfNamesake(const PeerInfo& info) const;
  /// The peer's place, if there is one or can be.
  Entry* PlaceFor(PeerId peer, bool& added);
  std::string WhyRefused(const PeerInfo& info) const;
  bool IsFullFor(const PeerInfo& info) const;
  void OnGone(PeerId peer, Presence presence);
  /// Whether it takes part as far as the hand is concerned.
  static bool Counts(const Entry& entry);
  /// Tells the haptic thread, as far as that knows or is to know the peer.
  void Tell(Entry& entry, MembershipChange::Kind kind);
  void HandOverEnd(Entry& entry);
  void HandOver(Entry& entry);
  bool Push(const Entry& entry, MembershipChange::Kind kind);
  void TellUnequal(Entry& entry);
  void TellTerms(Entry& entry);
  void Say(std::string line);

  PeerId self_;
  std::uint64_t scene_hash_;
  std::string name_;
  OwnTerms terms_;
  std::uint64_t parameters_hash_;
  mutable std::mutex mutex_;
  std::map<PeerId, Entry> entries_;
  SceneOffers offers_;
  ForceTerms own_;
  std::optional<PeerInfo> twin_;
  std::set<std::pair<PeerId, Drop>> refusals_told_;
  std::uint64_t departures_ = 0;
  bool crowd_told_ = false;
  std::vector<std::string> news_;
  std::size_t untold_ = 0;  // lines that found no room
  SpscQueue<MembershipChange> changes_{256};
};

}  // namespace tandem
