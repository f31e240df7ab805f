#pragma once

#include <map>
#include <memory>
#include <random>
#include <vector>

#include "collab/simulated/network/simulated_network.h"
#include "engine/world/world_model.h"

namespace tandem {

/// A member of a simulated session that has keys and keeps to none of the rules. It forges claims,
/// events, states and manifests, replays what it hears, and comes and goes, all drawn from a seed.
/// It cannot speak in another peer's name, because transports prevent that. It never claims to hold
/// a shared body, because peers couple with every holder by design.
class HostileMember : private Inbox {
 public:
  /// `scene_hash` is that of the session's scene, with which peers accept it.
  HostileMember(SimulatedNetwork& network, PeerId id, std::uint64_t seed, std::uint64_t scene_hash,
                const WorldModel& model);

  PeerId id() const noexcept { return id_; }
  /// Runs one millisecond.
  void Step();
  /// Goes for good.
  void Leave();
  /// Returns how many turns to speak it has had.
  std::uint64_t stated() const noexcept { return stated_; }

 private:
  void OnState(const ObjectState& state, std::int64_t) override { state_ = state; }
  void OnLinks(const CouplingLinks&, std::int64_t) override {}
  void OnView(const ViewFrame&, std::int64_t) override {}
  void OnPeerInfo(const PeerInfo& info, std::int64_t) override;
  void OnPeerLeft(PeerId peer) override { received_.erase(peer); }
  void OnPeerLost(PeerId) override {}
  void OnEvent(const Event& event, std::int64_t) override;
  void OnScene(const SceneManifest&) override {}

  std::uint32_t Draw(std::uint32_t count) { return static_cast<std::uint32_t>(random_() % count); }
  ObjectId DrawObject();
  std::uint32_t DrawEpoch(ObjectId object);
  PeerId DrawPeer();
  void SayClaims();
  void SayEvent();
  void SayState();
  void SayScene();

  SimulatedNetwork* network_;
  PeerId id_;
  std::mt19937_64 random_;
  std::uint64_t scene_hash_;
  const WorldModel* model_;
  std::unique_ptr<Transport> transport_;  // null: away
  bool gone_ = false;
  PeerInfo info_;
  std::map<PeerId, PeerInfo> received_;
  std::map<ObjectId, std::uint32_t> epochs_;  // greatest epochs that it heard of
  std::vector<Event> events_;                 // last events heard, for replay
  ObjectState state_;                         // last state heard, for replay
  std::uint32_t seq_ = 0;
  std::uint64_t stated_ = 0;
};

}  // namespace tandem
