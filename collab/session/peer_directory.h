#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "collab/session/drop_counts.h"
#include "collab/session/membership.h"
#include "collab/session/person_colour.h"
#include "collab/session/scene_agreement.h"
#include "engine/realtime/spsc_queue.h"

namespace tandem {

/// The parts of our own scene that matter for meeting others.
struct OwnTerms {
  Sha256 scene_digest{};  // digest of its content, as in SceneHash
  ForceParameters parameters;
  double heaviest_kg = 0;        // heaviest moving body
  std::vector<ObjectId> shared;  // bodies that several may hold
};

/// Keeps the peers of the session, from their peer_info (paper §6.1: anyone may enter or leave at
/// any time). The transport's control thread reports to it, the program's main thread asks it.
/// Changes that matter for forces go to the haptic thread through a queue. A peer with other force
/// parameters is taken in, but not as a holder of shared bodies. At most kMost peers are kept, and
/// at most kMaxPeers - 1 active ones are taken in; a further one comes in when another has gone.
class PeerDirectory {
 public:
  /// Most peers kept. Peers beyond it are not taken in; the peer that has been gone longest is
  /// forgotten.
  static constexpr std::size_t kMost = 128;
  /// Most lines that wait to be taken.
  static constexpr std::size_t kMostNews = 256;
  /// Most lines about refused samples, over all peers: invented peers may be many.
  static constexpr std::size_t kMostRefusals = 64;

  enum class Presence : std::uint8_t { kHere, kLeft, kLost };

  struct Entry {
    PeerInfo info;
    Presence presence = Presence::kHere;
    std::string told_name;  // its name as it says it
    int namesake = 1;       // its number among the peers of that name
    std::string refused;    // why not taken in: other protocol or scene, no place; else empty
    bool unequal = false;   // has other force parameters
    bool felt = false;      // the haptic thread knows that it is here, or is to be told
    bool reached = false;   // the haptic thread has received a change by which the peer is here
    // changes that wait for room in the queue to the haptic thread; the end goes first
    std::optional<MembershipChange::Kind> owed_end;
    std::optional<MembershipChange::Kind> owed_here;
    std::uint64_t gone = 0;  // number of its departure, for a peer that is gone
    // numbers of its first and newest information among all that came
    std::uint64_t first_heard = 0;
    std::uint64_t last_heard = 0;
    bool unequal_told = false;
    std::string terms_told;  // difference of its force terms from ours, as last reported
  };

  /// `name`: our own name. Others of one name and role that are here get numbers: "anna (2)". A
  /// peer that is gone gives up its entry to the next of its name: a person appears once.
  PeerDirectory(PeerId self, std::uint64_t scene_hash, std::string name = {}, OwnTerms terms = {});

  void OnPeerInfo(const PeerInfo& info);
  void OnPeerLeft(PeerId peer) { OnGone(peer, Presence::kLeft); }
  void OnPeerLost(PeerId peer) { OnGone(peer, Presence::kLost); }
  void OnScene(const SceneManifest& manifest);
  void OnSceneWithdrawn(PeerId peer);
  /// Takes note that another program uses our keys.
  void OnTwin(const PeerInfo& info);
  /// Sets our own force terms, which the other peers' are compared with; called when they change.
  void SetOwnTerms(const ForceTerms& terms);
  /// Passes changes that found no room in the haptic thread's queue, as far as there is room.
  void NotifyOwed();
  /// Reports for each peer which of its samples were refused, once for each reason.
  void NotifyRefusals(const DropTable& drops);
  /// Returns whether the other program with our keys was here first, by its beat and ours.
  bool TwinCameBefore(std::uint32_t beat) const;

  std::vector<Entry> Entries() const;
  /// The name of a peer for a person; "somebody" if it is not known.
  std::string NameOf(PeerId peer) const;
  /// Counts the active peers of our scene that were here before us, by their beats and our own
  /// `beat`. Of peers that came with us, the ones with a lower id count.
  std::size_t CameBefore(std::uint32_t beat) const;
  /// Returns the colour for our own user, by our own `beat`. `now`: the colour that it has.
  PersonColour ColourFor(std::uint32_t beat, PersonColour now) const;
  /// The active peer here of that name; 0: none.
  PeerId PeerNamed(const std::string& name) const;
  /// The session's scene, as other peers offer it; nullopt: no peer has offered any.
  std::optional<SceneManifest> SessionScene() const;
  /// Returns the news since the last call, a line each: "anna joined", "anna left", "anna is lost",
  /// "anna is back".
  std::vector<std::string> TakeNotifications();
  /// The haptic thread's end of the queue.
  SpscQueue<MembershipChange>& changes() noexcept { return changes_; }

 private:
  int NumberOfNamesake(const PeerInfo& info) const;
  /// Forgets those of that name that are gone.
  void Replace(const PeerInfo& by);
  /// Gives the number of a lost peer to the program that came after it fell silent.
  void RenameAfter(const Entry& lost);
  static std::string NumberedName(const Entry& entry);
  /// The peer's place, old or new; null if all are taken.
  Entry* PlaceFor(PeerId peer, bool& added);
  std::string WhyRefused(const PeerInfo& info) const;
  bool IsFullFor(const PeerInfo& info) const;
  void OnGone(PeerId peer, Presence presence);
  /// Returns whether the peer takes part as far as the hand is concerned.
  static bool Counts(const Entry& entry);
  /// Tells the haptic thread, if it knows the peer or is to know it.
  void Tell(Entry& entry, MembershipChange::Kind kind);
  void HandOverEnd(Entry& entry);
  void HandOver(Entry& entry);
  bool Push(const Entry& entry, MembershipChange::Kind kind);
  void NotifyUnequal(Entry& entry);
  void NotifyTerms(Entry& entry);
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
  std::uint64_t heard_ = 0;
  bool crowd_told_ = false;
  std::vector<std::string> notifications_;
  std::size_t untold_ = 0;  // lines that found no room
  SpscQueue<MembershipChange> changes_{256};
};

}  // namespace tandem
