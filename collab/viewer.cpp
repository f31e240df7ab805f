#include "collab/viewer.h"

#include <algorithm>

namespace tandem {

namespace {
constexpr std::size_t kMaxAges = 1U << 20U;  // an hour of four peers at 60 Hz, 4 MB
}

ViewerPicture Viewer::Picture() const {
  const std::lock_guard lock(mutex_);
  ViewerPicture picture{.scene = scene_,
                        .peers = {},
                        .samples = samples_,
                        .first_sample_ns = first_sample_ns_,
                        .newest_sample_ns = newest_sample_ns_};
  for (const auto& [id, peer] : peers_) picture.peers.push_back(peer);
  return picture;
}

std::vector<float> Viewer::SampleAgesMs() const {
  const std::lock_guard lock(mutex_);
  return ages_ms_;
}

void Viewer::OnView(const ViewFrame& frame, std::int64_t arrival_ns) {
  const std::lock_guard lock(mutex_);
  ViewedPeer& peer = peers_[frame.peer];
  peer.info.peer =
      frame.peer;  // whether it is here only its peer_info tells: this may be a straggler
  peer.delay_ms = static_cast<double>(frame.delay_ms);
  peer.mirror_lag_mm = static_cast<double>(frame.mirror_lag_mm);
  peer.link_force = static_cast<double>(frame.link_force);
  peer.V_W = frame.V_W;
  peer.seq = frame.seq;
  peer.heard_ns = arrival_ns;
  // frames of a peer with many bodies bring some of them each
  for (std::size_t i = 0; i < std::min<std::size_t>(frame.count, kMaxViewBodies); ++i) {
    const ViewBody& body = frame.bodies[i];
    const auto known = std::find_if(peer.bodies.begin(), peer.bodies.end(), [&](const ViewBody& b) {
      return b.object == body.object;
    });
    if (known == peer.bodies.end()) {
      peer.bodies.push_back(body);
    } else {
      *known = body;
    }
  }
  if (samples_++ == 0) first_sample_ns_ = arrival_ns;
  newest_sample_ns_ = arrival_ns;
  if (ages_ms_.size() < kMaxAges) {
    ages_ms_.push_back(
        static_cast<float>(static_cast<double>(arrival_ns - frame.sample_ns) * 1e-6));
  }
}

void Viewer::OnPeerInfo(const PeerInfo& info, std::int64_t arrival_ns) {
  const std::lock_guard lock(mutex_);
  ViewedPeer& peer = peers_[info.peer];
  peer.info = info;
  peer.presence = ViewedPeer::Presence::kHere;
  peer.heard_ns = std::max(peer.heard_ns, arrival_ns);
}

void Viewer::OnPeerLeft(PeerId peer) {
  const std::lock_guard lock(mutex_);
  if (const auto it = peers_.find(peer); it != peers_.end()) {
    it->second.presence = ViewedPeer::Presence::kLeft;
  }
}

void Viewer::OnPeerLost(PeerId peer) {
  const std::lock_guard lock(mutex_);
  if (const auto it = peers_.find(peer); it != peers_.end()) {
    it->second.presence = ViewedPeer::Presence::kLost;
  }
}

void Viewer::OnScene(const SceneManifest& manifest) {
  const std::lock_guard lock(mutex_);
  scene_ = manifest;
}

}  // namespace tandem
