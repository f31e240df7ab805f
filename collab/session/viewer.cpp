#include "collab/session/viewer.h"

#include <algorithm>

namespace tandem {

namespace {

bool AreNamesakes(const ViewedPeer& a, const ViewedPeer& b) {
  return a.info.peer != b.info.peer && !a.info.name.empty() && a.info.name == b.info.name &&
         a.info.role == b.info.role;
}

void NumberNamesakes(std::vector<ViewedPeer>& peers) {
  std::vector<ViewedPeer*> here;
  for (ViewedPeer& peer : peers) {
    const bool counts = peer.presence == ViewedPeer::Presence::kHere && !peer.info.name.empty();
    if (counts) here.push_back(&peer);
  }
  std::ranges::stable_sort(here, {}, &ViewedPeer::first_heard_ns);
  std::map<std::pair<std::string, Role>, int> numbers;
  for (ViewedPeer* peer : here) {
    const int number = ++numbers[{peer->info.name, peer->info.role}];
    if (number > 1) peer->info.name += " (" + std::to_string(number) + ")";
  }
}

}  // namespace

std::string OtherProtocol(const PeerInfo& info) {
  if (info.protocol == kProtocol) return {};
  return "uses protocol " + std::to_string(info.protocol) + ", this program " +
         std::to_string(kProtocol) + ": update both to one version";
}

bool Viewer::IsOfAScene(ObjectId object) const {
  const SceneManifest* const session = offers_.session();
  const bool known = session != nullptr && !session->bodies.empty();
  return object < (known ? session->bodies.size() : kMaxSceneBodies);
}

std::uint64_t Viewer::refused() const {
  const std::lock_guard lock(mutex_);
  return refused_;
}

ViewerPicture Viewer::Picture() const {
  const std::lock_guard lock(mutex_);
  const SceneManifest* const session = offers_.session();
  ViewerPicture picture{.scene = session == nullptr ? std::nullopt : std::optional(*session),
                        .peers = {},
                        .samples = samples_,
                        .first_sample_ns = first_sample_ns_,
                        .newest_sample_ns = newest_sample_ns_};
  for (const auto& [id, peer] : peers_) picture.peers.push_back(peer);
  NumberNamesakes(picture.peers);
  return picture;
}

PersonColour Viewer::ColourFor(const PeerInfo& self, PersonColour now) const {
  const std::lock_guard lock(mutex_);
  std::vector<ColouredPerson> others;
  for (const auto& [id, peer] : peers_) {
    if (peer.presence != ViewedPeer::Presence::kHere || id == self.peer) continue;
    others.push_back({.name = peer.info.name,
                      .role = peer.info.role,
                      .colour = peer.info.colour,
                      .before = CameBefore(peer.info, self.peer, self.beat)});
  }
  return ChooseColour(self.name, self.role, now, others);
}

FrameAges Viewer::Ages() const {
  const std::lock_guard lock(mutex_);
  return ages_;
}

void Viewer::OnView(const ViewFrame& frame, std::int64_t arrival_ns) {
  const std::lock_guard lock(mutex_);
  if (replaced_.contains(frame.peer)) return;
  ViewedPeer* const place = PlaceFor(frame.peer);
  if (place == nullptr) return;
  ViewedPeer& peer = *place;
  // only its peer_info tells whether it is here: this may be a straggler
  peer.info.peer = frame.peer;
  peer.delay_ms = static_cast<double>(frame.delay_ms);
  peer.mirror_lag_mm = static_cast<double>(frame.mirror_lag_mm);
  peer.link_force = static_cast<double>(frame.link_force);
  peer.V_W = frame.V_W;
  peer.seq = frame.seq;
  if (peer.first_heard_ns == 0) peer.first_heard_ns = arrival_ns;
  peer.received_ns = arrival_ns;
  // each frame of a peer with many bodies has some of them
  for (std::size_t i = 0; i < std::min<std::size_t>(frame.count, kMaxViewBodies); ++i) {
    const ViewBody& body = frame.bodies[i];
    if (!IsOfAScene(body.object)) {
      ++refused_;
      continue;
    }
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
  // a sender can write any number there
  if (frame.sample_ns > arrival_ns || frame.sample_ns < arrival_ns - FrameAges::kMost_ns) {
    ages_.others = true;
  } else {
    ages_.of_this_machine.Add(arrival_ns - frame.sample_ns);
  }
}

void Viewer::OnPeerInfo(const PeerInfo& info, std::int64_t arrival_ns) {
  const std::lock_guard lock(mutex_);
  offers_.OnPresence(info.peer, true);
  replaced_.erase(info.peer);
  ViewedPeer* const place = PlaceFor(info.peer);
  if (place == nullptr) return;
  ViewedPeer& peer = *place;
  const bool renamed = peer.info.name != info.name;
  if (peer.presence != ViewedPeer::Presence::kHere) peer.came_back = true;
  peer.info = info;
  peer.introduced = true;
  peer.presence = ViewedPeer::Presence::kHere;
  if (peer.first_heard_ns == 0) peer.first_heard_ns = arrival_ns;
  peer.received_ns = std::max(peer.received_ns, arrival_ns);
  if (renamed) TakePlacesOfNamesakes(peer);
}

void Viewer::OnPeerLeft(PeerId peer) {
  NoteEnd(peer, ViewedPeer::Presence::kLeft);
}

void Viewer::OnPeerLost(PeerId peer) {
  NoteEnd(peer, ViewedPeer::Presence::kLost);
}

void Viewer::OnScene(const SceneManifest& manifest) {
  const std::lock_guard lock(mutex_);
  offers_.OnScene(manifest);
}

void Viewer::OnSceneWithdrawn(PeerId peer) {
  const std::lock_guard lock(mutex_);
  offers_.OnWithdrawn(peer);
}

ViewedPeer* Viewer::PlaceFor(PeerId peer) {
  if (const auto known = peers_.find(peer); known != peers_.end()) return &known->second;
  if (peers_.size() >= kMost) {
    const auto gone = std::find_if(peers_.begin(), peers_.end(), [](const auto& entry) {
      return entry.second.presence != ViewedPeer::Presence::kHere || !entry.second.introduced;
    });
    if (gone == peers_.end()) return nullptr;
    peers_.erase(gone);
  }
  // a peer that has since used this id gives it back
  for (auto& [id, other] : peers_) {
    if (other.first_id == peer) other.first_id = 0;
  }
  return &peers_[peer];
}

void Viewer::NoteEnd(PeerId peer, ViewedPeer::Presence presence) {
  const std::lock_guard lock(mutex_);
  offers_.OnPresence(peer, false);
  const auto it = peers_.find(peer);
  if (it == peers_.end()) return;
  it->second.presence = presence;
  // it fell silent before a namesake came: the same person, whose first program has crashed
  for (auto& [id, other] : peers_) {
    const bool after = other.presence == ViewedPeer::Presence::kHere &&
                       other.first_heard_ns > it->second.received_ns;
    if (after && AreNamesakes(other, it->second)) return TakePlace(other, peer);
  }
}

void Viewer::TakePlace(ViewedPeer& of, PeerId gone) {
  const PeerId lasting = LastingId(peers_.at(gone));
  peers_.erase(gone);
  if (replaced_.size() < kMost) replaced_.insert(gone);
  of.came_back = true;
  // unless another peer has used it since
  const bool taken = std::any_of(peers_.begin(), peers_.end(), [&](const auto& entry) {
    return &entry.second != &of && LastingId(entry.second) == lasting;
  });
  if (!taken) of.first_id = lasting;
}

void Viewer::TakePlacesOfNamesakes(ViewedPeer& peer) {
  std::vector<PeerId> gone;
  for (const auto& [id, other] : peers_) {
    if (other.presence != ViewedPeer::Presence::kHere && AreNamesakes(other, peer)) {
      gone.push_back(id);
    }
  }
  for (const PeerId id : gone) TakePlace(peer, id);
}

}  // namespace tandem
