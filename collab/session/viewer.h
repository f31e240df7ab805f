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

#include "collab/session/person_colour.h"
#include "collab/session/scene_agreement.h"
#include "collab/session/transport.h"
#include "engine/realtime/histogram.h"

namespace tandem {

/// Mark by which viewers see that a recording is shown instead of a present user.
inline constexpr std::string_view kReplayMark = " (replay)";
inline constexpr std::size_t kMaxPeerName = 64;  // bytes

/// Returns the name with the mark, shortened where both would be too long.
inline std::string ReplayName(const std::string& name) {
  std::size_t length = std::min(name.size(), kMaxPeerName - kReplayMark.size());
  // do not cut within a character of UTF-8
  while (length < name.size() && length > 0 && (name[length] & 0xC0) == 0x80) --length;
  return name.substr(0, length) + std::string(kReplayMark);
}
inline bool IsReplay(const PeerInfo& info) {
  return info.role == Role::kActive && info.name.ends_with(kReplayMark);
}

/// A peer in the view of a viewer.
struct ViewedPeer {
  /// kUnknown: the viewer itself has left, and hears no peer any more.
  enum class Presence : std::uint8_t { kHere, kLost, kLeft, kUnknown };

  PeerInfo info;
  Presence presence = Presence::kHere;
  bool introduced = false;  // it has said that it is here; frames alone may be anybody's
  PeerId first_id = 0;      // id of the first program with this name and role; 0: its own
  bool came_back = false;   // it is here again after it was gone, or took such a program's place
  std::int64_t first_heard_ns = 0;
  double delay_ms = 0;           // half its loop age to its coupled peers, as it says
  double mirror_lag_mm = 0;      // greatest lag of its mirrors, as it says
  double link_force = 0;         // N; largest force of its couplings
  Twist V_W;                     // twist of its held body, at the body's X_W
  std::uint32_t seq = 0;         // number of its newest frame
  std::int64_t received_ns = 0;  // newest sign of it, on this machine's clock
  std::vector<ViewBody> bodies;  // newest poses
};

/// Returns the id that stays when a peer's program is started again.
inline PeerId LastingId(const ViewedPeer& peer) {
  return peer.first_id != 0 ? peer.first_id : peer.info.peer;
}

/// Returns why the information of a program may be misunderstood: "speaks protocol 5, this program
/// 4: update both to one version"; empty if it speaks our protocol.
std::string OtherProtocol(const PeerInfo& info);

/// The picture of a viewer at one moment.
struct ViewerPicture {
  std::optional<SceneManifest> scene;  // the session's; empty until an active peer offers one
  std::vector<ViewedPeer> peers;       // by id; peers that left stay, marked, until they come back
  std::uint64_t samples = 0;           // view frames received so far
  std::int64_t first_sample_ns =
      0;  // when the first of them came, and the newest; this machine's clock
  std::int64_t newest_sample_ns = 0;
  PeerId self = 0;  // id of the viewing program, where it is a peer, too
};

/// Ages of view frames at arrival: their sender's stamp against this machine's clock. Only clocks
/// of one machine can be compared.
struct FrameAges {
  static constexpr std::int64_t kMost_ns = 60'000'000'000;  // longest delay within a machine

  Histogram of_this_machine;
  bool others = false;  // a stamp came from another machine
};

/// A passive onlooker's side of a session: keeps the received frames and answers what to show.
/// Needs no window; sends no poses. The transport's threads and the reader's may call at once.
class Viewer : public Inbox {
 public:
  /// Most peers kept. Then a new peer replaces one that is gone or has never said that it is here;
  /// if all are here, it is not taken.
  static constexpr std::size_t kMost = 128;

  /// Returns the session's state. Several persons of one name and role that are here have numbers,
  /// by the order in which they were heard: "anna", "anna (2)".
  ViewerPicture Picture() const;
  /// Returns the colour for the participant that looks on by this viewer. `now`: the colour that it
  /// has.
  PersonColour ColourFor(const PeerInfo& self, PersonColour now) const;
  FrameAges Ages() const;
  /// Counts poses of bodies that the session's scene does not have; they are not kept.
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
  /// Returns whether the session's scene has the body; before a scene is known, whether one may
  /// have it.
  bool IsOfAScene(ObjectId object) const;
  /// Returns the peer's place; null if all places are taken by peers that are here.
  ViewedPeer* PlaceFor(PeerId peer);
  void NoteEnd(PeerId peer, ViewedPeer::Presence presence);
  /// Gives a program that is started again, and so has a new id, its old place: a person appears
  /// once. `gone` is forgotten, with the frames that still come from it.
  void TakePlace(ViewedPeer& of, PeerId gone);
  void TakePlacesOfNamesakes(ViewedPeer& peer);

  mutable std::mutex mutex_;
  SceneOffers offers_{true};
  std::map<PeerId, ViewedPeer> peers_;
  std::set<PeerId> replaced_;  // peers whose places others took; their frames are stragglers
  std::uint64_t samples_ = 0;
  std::uint64_t refused_ = 0;
  std::int64_t first_sample_ns_ = 0;
  std::int64_t newest_sample_ns_ = 0;
  FrameAges ages_;
};

}  // namespace tandem
