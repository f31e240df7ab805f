#include "collab/simulated/simulated_network.h"

namespace tandem {

class SimulatedNetwork::Link : public Transport {
 public:
  Link(SimulatedNetwork& network, PeerId peer) : network_(&network), peer_(peer) {}
  ~Link() override { network_->Remove(peer_, false); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  void Publish(const ObjectState& state) override {
    ForOthers(Role::kActive, [&](Inbox& inbox) {
      inbox.OnState(state, network_->now_ns_);
    });
  }
  void Publish(const CouplingLinks& links) override {
    ForOthers(Role::kActive, [&](Inbox& inbox) {
      inbox.OnLinks(links, network_->now_ns_);
    });
  }
  void Publish(const ViewFrame& frame) override {
    ForOthers(Role::kViewer, [&](Inbox& inbox) {
      inbox.OnView(frame, network_->now_ns_);
    });
  }
  void Publish(const PeerInfo& info) override {
    const auto self = network_->members_.find(peer_);
    if (self == network_->members_.end()) return;
    self->second.info = info;
    const auto tell = [&](Inbox& inbox) {
      inbox.OnPeerInfo(info, network_->now_ns_);
    };
    ForOthers(Role::kActive, tell);
    ForOthers(Role::kViewer, tell);
  }
  void Publish(const Event& event) override {
    ForOthers(Role::kActive, [&](Inbox& inbox) {
      inbox.OnEvent(event, network_->now_ns_);
    });
  }
  void Publish(const SceneManifest& manifest) override {
    network_->scene_ = manifest;
    const auto tell = [&](Inbox& inbox) {
      inbox.OnScene(manifest);
    };
    ForOthers(Role::kActive, tell);
    ForOthers(Role::kViewer, tell);
  }
  void Leave() override { network_->Remove(peer_, true); }

 private:
  template <typename Tell>
  void ForOthers(Role role, const Tell& tell) {
    if (!network_->members_.contains(peer_)) return;
    for (auto& [id, member] : network_->members_) {
      if (id != peer_ && member.role == role) tell(*member.inbox);
    }
  }

  SimulatedNetwork* network_;
  PeerId peer_;
};

std::unique_ptr<Transport> SimulatedNetwork::Join(PeerId peer, Role role, Inbox& inbox) {
  for (const auto& [id, member] : members_) {
    if (member.info) inbox.OnPeerInfo(*member.info, now_ns_);
  }
  if (scene_) inbox.OnScene(*scene_);
  members_[peer] = {role, &inbox, std::nullopt};
  return std::make_unique<Link>(*this, peer);
}

void SimulatedNetwork::Remove(PeerId peer, bool graceful) {
  if (members_.erase(peer) == 0) return;
  for (auto& [id, member] : members_) {
    if (graceful) {
      member.inbox->OnPeerLeft(peer);
    } else {
      member.inbox->OnPeerLost(peer);
    }
  }
}

}  // namespace tandem
