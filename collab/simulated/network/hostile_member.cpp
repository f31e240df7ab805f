#include "collab/simulated/network/hostile_member.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace tandem {

namespace {
constexpr std::size_t kKept = 16;  // events for replay
}  // namespace

HostileMember::HostileMember(SimulatedNetwork& network, PeerId id, std::uint64_t seed,
                             std::uint64_t scene_hash, const WorldModel& model)
    : network_(&network), id_(id), random_(seed), scene_hash_(scene_hash), model_(&model) {
  info_.peer = id;
  info_.name = "mallory";
  info_.scene_hash = scene_hash;
}

void HostileMember::OnPeerInfo(const PeerInfo& info, std::int64_t) {
  received_[info.peer] = info;
  for (const Claim& claim : info.claims) {
    std::uint32_t& epoch = epochs_[claim.object];
    epoch = std::max(epoch, claim.epoch);
  }
  if (info_.params_hash == 0) info_.params_hash = info.params_hash;
}

void HostileMember::OnEvent(const Event& event, std::int64_t) {
  if (events_.size() >= kKept) events_.erase(events_.begin());
  events_.push_back(event);
}

ObjectId HostileMember::DrawObject() {
  return model_->object[Draw(static_cast<std::uint32_t>(model_->object.size()))];
}

std::uint32_t HostileMember::DrawEpoch(ObjectId object) {
  const std::uint32_t known = epochs_[object];
  const std::array<std::uint32_t, 10> some{0,          1,         known,       known + 1,
                                           known + 1,  known + 2, known + 900, known + 5000,
                                           kLastEpoch, 0xFFFFFFFF};
  return some[Draw(some.size())];
}

PeerId HostileMember::DrawPeer() {
  if (received_.empty() || Draw(4) == 0) return id_;
  auto it = received_.begin();
  std::advance(it, Draw(static_cast<std::uint32_t>(received_.size())));
  return it->first;
}

void HostileMember::SayClaims() {
  ++info_.beat;
  info_.claims.clear();
  info_.beliefs.clear();
  const std::uint32_t count = Draw(4);
  for (std::uint32_t i = 0; i < count; ++i) {
    const ObjectId object = DrawObject();
    const bool held = !model_->scene.bodies[object].shared && Draw(2) == 0;
    info_.claims.push_back({object, DrawEpoch(object), held});
  }
  for (const ObjectId object : model_->object) {
    if (Draw(2) == 0) info_.beliefs.push_back({object, DrawPeer(), DrawEpoch(object)});
  }
  transport_->Publish(info_);
}

void HostileMember::SayEvent() {
  Event event;
  if (!events_.empty() && Draw(3) == 0) {
    event = events_[Draw(static_cast<std::uint32_t>(events_.size()))];
  } else {
    constexpr std::array kKinds{EventKind::kGrant, EventKind::kRefuse, EventKind::kRelease,
                                EventKind::kHeal};
    event.kind = kKinds[Draw(kKinds.size())];
    event.object = DrawObject();
    event.epoch = DrawEpoch(event.object);
    event.to = DrawPeer();
    event.X_WB.p = Vec3(0.01 * Draw(4), 0.01 * Draw(4), 0.01 * Draw(4));
  }
  // by asking it would come to answer for bodies as any peer does
  if (event.kind == EventKind::kAsk) return;
  event.peer = id_;
  event.seq = ++seq_;
  transport_->Publish(event);
}

void HostileMember::SayState() {
  ObjectState state = state_;
  state.peer = id_;
  if (Draw(2) == 0) state.object = DrawObject();
  state.epoch = DrawEpoch(state.object);
  state.seq = ++seq_;
  state.flags = Draw(2) == 0 ? kStateParked : 0U;
  state.X_WB.p.x() += 0.01 * Draw(4);
  transport_->Publish(state);
}

void HostileMember::SayScene() {
  SceneManifest manifest;
  manifest.offered_by = id_;
  manifest.revision = Draw(3);
  manifest.content_hash = Draw(2) == 0 ? scene_hash_ : random_();
  manifest.voxel_size = 1e-6 * (1 + Draw(1000));
  transport_->Publish(manifest);
}

void HostileMember::Step() {
  if (gone_) return;
  if (!transport_) {
    if (Draw(500) != 0) return;
    transport_ = network_->Join(id_, Role::kActive, *this);
    SayClaims();
    return;
  }
  const std::uint32_t turn = Draw(2000);
  if (turn == 0) {
    if (Draw(2) == 0) transport_->Leave();
    transport_.reset();
    received_.clear();
    return;
  }
  if (turn % 20 != 0) return;
  ++stated_;
  switch (turn / 20 % 8) {
    case 0:
    case 1:
    case 2:
      return SayClaims();
    case 3:
    case 4:
    case 5:
      return SayEvent();
    case 6:
      return SayState();
    default:
      return SayScene();
  }
}

void HostileMember::Leave() {
  gone_ = true;
  if (transport_) transport_->Leave();
  transport_.reset();
}

}  // namespace tandem
