#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "collab/scene_agreement.h"
#include "collab/transport.h"

namespace tandem {

/// A peer as a viewer knows it.
struct ViewedPeer {
  enum class Presence : std::uint8_t { kHere, kLost, kLeft };

  PeerInfo info;
  Presence presence = Presence::kHere;
  double delay_ms = 0;           // half its loop age to its partners, as it says itself
  double mirror_lag_mm = 0;      // and how far others' bodies are there from where they were said
  double link_force = 0;         // N, the largest of its couplings
  Twist V_W;                     // of what its hand holds, at the body's X_W
  std::uint32_t seq = 0;         // of its newest frame
  std::int64_t heard_ns = 0;     // newest sign of it, this machine's clock
  std::vector<ViewBody> bodies;  // newest poses
};

/// What a viewer shows, at one moment.
struct ViewerPicture {
  std::optional<SceneManifest> scene;  // the session's; not before an active peer has offered one
  std::vector<ViewedPeer> peers;       // by id; those that left stay, marked
  std::uint64_t samples = 0;           // view frames received so far
  std::int64_t first_sample_ns =
      0;  // when the first of them came, and the newest; this machine's clock
  std::int64_t newest_sample_ns = 0;
};

/// A passive onlooker's side of a session: keeps what is heard, answers what to show. Needs no
/// window; says nothing of poses to anybody. Calls may come from the transport's threads and from
/// the reader's at once.
class Viewer : public Inbox {
 public:
  /// Peers that are kept; then those gone make room, and when all are here no more are taken.
  static constexpr std::size_t kMost = 128;

  ViewerPicture Picture() const;
  /// Ages of view frames at arrival (sender's stamp against our clock, ms): meaningful on one host
  /// only.
  std::vector<float> SampleAgesMs() const;

  void OnState(const ObjectState&, std::int64_t) override {}
  void OnLinks(const CouplingLinks&, std::int64_t) override {}
  void OnView(const ViewFrame& frame, std::int64_t arrival_ns) override;
  void OnPeerInfo(const PeerInfo& info, std::int64_t arrival_ns) override;
  void OnPeerLeft(PeerId peer) override;
  void OnPeerLost(PeerId peer) override;
  void OnEvent(const Event&, std::int64_t) override {}
  void OnScene(const SceneManifest& manifest) override;

 private:
  /// The peer's place; null: there are too many, all of them here.
  ViewedPeer* PlaceFor(PeerId peer);
  void NoteEnd(PeerId peer, ViewedPeer::Presence presence);

  mutable std::mutex mutex_;
  SceneOffers offers_;
  std::map<PeerId, ViewedPeer> peers_;
  std::uint64_t samples_ = 0;
  std::int64_t first_sample_ns_ = 0;
  std::int64_t newest_sample_ns_ = 0;
  std::vector<float> ages_ms_;
};

}  // namespace tandem
