#include "collab/peer_node.h"

#include <cmath>
#include <utility>

namespace tandem {

namespace {

constexpr std::int64_t kViewPeriodNs = 16'666'667;  // 60 Hz

/// Whether something due every `period_ns` is due now; keeps the beat without catching up.
bool TakeTurn(std::int64_t now_ns, std::int64_t period_ns, std::int64_t& next_ns) {
  // half a millisecond early is on time: the caller comes once a millisecond
  if (now_ns + 500'000 < next_ns) return false;
  next_ns = next_ns + period_ns > now_ns ? next_ns + period_ns : now_ns + period_ns;
  return true;
}

}  // namespace

PeerNode::PeerNode(std::shared_ptr<const WorldModel> model, std::unique_ptr<Device> device,
                   std::uint64_t scene_hash, const NodeOptions& options)
    : model_(std::move(model)),
      options_(options),
      world_(model_, {.helpers = options.helpers}),
      device_(std::move(device)),
      directory_(options.peer.id, scene_hash),
      inbox_(options.conditions, directory_, options.waiting),
      peer_(world_, *device_, inbox_, options.peer) {
  info_ = {.peer = options.peer.id,
           .protocol = kProtocol,
           .beat = 0,
           .role = Role::kActive,
           .name = options.name,
           .scene_hash = scene_hash,
           .params_hash = 0,
           .claims = {}};
  if (options.peer.held_object >= 0) {
    info_.claims.push_back(
        {.object = static_cast<ObjectId>(options.peer.held_object), .epoch = 1, .held = true});
  }
  manifest_ = {.offered_by = options.peer.id,
               .revision = 1,
               .content_hash = scene_hash,
               .name = model_->scene.name,
               .file = std::filesystem::absolute(model_->scene.file).string(),
               .voxel_size = model_->scene.voxel_size,
               .contact_stiffness = 0,
               .force_layer = model_->scene.force_layer,
               .contact_model = static_cast<std::uint8_t>(model_->scene.contact),
               .friction = model_->scene.friction,
               .bodies = {}};
  for (const SceneBody& body : model_->scene.bodies) manifest_.bodies.push_back({body.name, 0});
}

void PeerNode::HapticFrame(std::int64_t now_ns) noexcept {
  peer_.Tick(now_ns, outbox_.back());
  outbox_.Publish();
}

void PeerNode::SendFrame(std::int64_t now_ns, Transport& transport) {
  const Outbox& out = outbox_.Read();
  if (!out.holds || out.state.seq == sent_seq_) return;
  if (TakeTurn(now_ns, std::llround(1e9 / options_.publish_hz), next_state_ns_)) {
    sent_seq_ = out.state.seq;
    transport.Publish(out.state);
    if (out.shared) transport.Publish(out.links);
  }
  if (TakeTurn(now_ns, kViewPeriodNs, next_view_ns_)) transport.Publish(out.view);
}

void PeerNode::ControlFrame(Transport& transport) {
  ++info_.beat;
  transport.Publish(info_);
  if (!std::exchange(offered_, true)) transport.Publish(manifest_);
}

}  // namespace tandem
