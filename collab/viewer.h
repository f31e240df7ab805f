#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "collab/scene_agreement.h"
#include "collab/transport.h"
#include "engine/realtime/histogram.h"

namespace tandem {

/// How those who look on are told that a recording is shown, not somebody who is there.
inline constexpr std::string_view kReplayMark = " (replay)";
inline constexpr std::size_t kMaxPeerName = 64;  // bytes

/// The name with the mark, shortened where both would be too long.
inline std::string ReplayName(const std::string& name) {
  std::size_t length = std::min(name.size(), kMaxPeerName - kReplayMark.size());
  // not within a character of UTF-8
  while (length < name.size() && length > 0 && (name[length] & 0xC0) == 0x80) --length;
  return name.substr(0, length) + std::string(kReplayMark);
}
inline bool IsReplay(const PeerInfo& info) {
  return info.role == Role::kActive && info.name.ends_with(kReplayMark);
}

/// A peer as a viewer knows it.
struct ViewedPeer {
  /// kUnknown: the viewer itself has left, and hears nothing of anybody any more.
  enum class Presence : std::uint8_t { kHere, kLost, kLeft, kUnknown };

  PeerInfo info;
  Presence presence = Presence::kHere;
  bool introduced = false;  // whether it has said that it is here; frames alone may be anybody's
  PeerId first_id = 0;     // id of the first program under this name and role; 0: its own
  bool came_back = false;  // whether it took the place of such a program that was gone
  std::int64_t first_heard_ns = 0;
  double delay_ms = 0;           // half its loop age to its partners, as it says itself
  double mirror_lag_mm = 0;      // and how far others' bodies are there from where they were said
  double link_force = 0;         // N, the largest of its couplings
  Twist V_W;                     // of what its hand holds, at the body's X_W
  std::uint32_t seq = 0;         // of its newest frame
  std::int64_t heard_ns = 0;     // newest sign of it, this machine's clock
  std::vector<ViewBody> bodies;  // newest poses
};

/// The id that stays when a peer's program is started again.
inline PeerId LastingId(const ViewedPeer& peer) {
  return peer.first_id != 0 ? peer.first_id : peer.info.peer;
}

/// Why what a program says may be misunderstood: "speaks protocol 5, this program 4: bring both to
/// one version"; empty: it speaks ours.
std::string OtherProtocol(const PeerInfo& info);

/// What a viewer shows, at one moment.
struct ViewerPicture {
  std::optional<SceneManifest> scene;  // the session's; not before an active peer has offered one
  std::vector<ViewedPeer> peers;       // by id; those that left stay, marked, until they come back
  std::uint64_t samples = 0;           // view frames received so far
  std::int64_t first_sample_ns =
      0;  // when the first of them came, and the newest; this machine's clock
  std::int64_t newest_sample_ns = 0;
  PeerId self = 0;  // of whoever looks on, where that is a peer, too
};

/// How old view frames were as they came: their sender's stamp against this machine's clock. Only
/// clocks of one machine have something in common.
struct FrameAges {
  static constexpr std::int64_t kMost_ns = 60'000'000'000;  // that a network within a machine has

  Histogram of_this_machine;
  bool others = false;  // whether a stamp was another machine's
};

/// A passive onlooker's side of a session: keeps what is heard, answers what to show. Needs no
/// window; says nothing of poses to anybody. Calls may come from the transport's threads and from
/// the reader's at once.
class Viewer : public Inbox {
 public:
  /// Peers that are kept; then those make room that are gone or have never said that they are here,
  /// and when all are here no more are taken.
  static constexpr std::size_t kMost = 128;

  ViewerPicture Picture() const;
  FrameAges Ages() const;
  /// Poses of bodies that the session's scene does not have; they are not kept.
  std::uint64_t refused() const;

  void OnState(const ObjectState&, std::int64_t) override {}
  void OnLinks(const CouplingLinks&, std::int64_t) override {}
  void OnView(const ViewFrame& frame, std::int64_t arrival_ns) override;
  void OnPeerInfo(const PeerInfo& info, std::int64_t arrival_ns) override;
  void OnPeerLeft(PeerId peer) override;
  void OnPeerLost(PeerId peer) override;
  void OnEvent(const Event&, std::int64_t) override {}
  void OnScene(const SceneManifest& manifest) override;
  void OnSceneWithdrawn(PeerId peer) override;

 private:
  /// Before a scene is known, whether one may have it.
  bool IsOfAScene(ObjectId object) const;
  /// The peer's place; null: there are too many, all of them here.
  ViewedPeer* PlaceFor(PeerId peer);
  void NoteEnd(PeerId peer, ViewedPeer::Presence presence);
  /// A program that is started again has a new id: its old place is taken, so that a person is
  /// there once. `gone` is forgotten, with what still comes of it.
  void TakePlace(ViewedPeer& of, PeerId gone);
  void TakePlacesOfNamesakes(ViewedPeer& peer);

  mutable std::mutex mutex_;
  SceneOffers offers_{true};
  std::map<PeerId, ViewedPeer> peers_;
  std::set<PeerId> replaced_;  // whose places others took; frames of theirs are stragglers
  std::uint64_t samples_ = 0;
  std::uint64_t refused_ = 0;
  std::int64_t first_sample_ns_ = 0;
  std::int64_t newest_sample_ns_ = 0;
  FrameAges ages_;
};

}  // namespace tandem
