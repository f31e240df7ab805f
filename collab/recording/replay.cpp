#include "collab/recording/replay.h"

#include <utility>

#include "engine/base/check.h"

namespace tandem {

/// Gives the recorded motion of the hand, and takes no force.
class Replay::Device final : public tandem::Device {
 public:
  void Start() noexcept override {}
  Anchor Read() noexcept override { return now; }
  void Render(const Wrench&) noexcept override {}
  void Rescale(double to) noexcept override {
    can.stiffness *= scale / to;
    can.damping *= scale / to;
    scale = to;
  }
  DeviceCapabilities capabilities() const noexcept override { return can; }
  Anchor now;
  DeviceCapabilities can;
  double scale = 1;
};

/// Keeps the state hash of the frame.
class Replay::Observer final : public FrameObserver {
 public:
  void Begin(std::int64_t, double) noexcept override {}
  void OnReceived(const MembershipChange&) noexcept override {}
  void OnReceived(const Event&) noexcept override {}
  void OnReceived(const ObjectState&) noexcept override {}
  void OnReceived(const CouplingLinks&) noexcept override {}
  void OnCommand(const Command&) noexcept override {}
  void OnDevice(const Anchor&) noexcept override {}
  void End(std::uint64_t state_hash) noexcept override { hash = state_hash; }
  std::uint64_t hash = 0;
};

Replay::Replay() : tap_(std::make_unique<Observer>()) {}
Replay::~Replay() = default;

Result<std::unique_ptr<Replay>> Replay::Create(const RecordingHeader& header,
                                               std::shared_ptr<const WorldModel> model,
                                               WorkerPool* workers) {
  const int object = header.peer.held_object;
  const auto bodies = static_cast<int>(model->body_index.size());
  if (object >= bodies ||
      (object >= 0 && model->body_index[static_cast<std::size_t>(object)] < 0)) {
    return Error{"the scene has no moving body " + std::to_string(object) + ", which was held"};
  }
  Result<std::shared_ptr<const CouplingLaw>> law = MakeLaw(header.law, header.limits, true);
  if (!law) return law.error();

  std::unique_ptr<Replay> replay(new Replay);
  auto device = std::make_unique<Device>();
  replay->device_ = device.get();
  device->can = header.device;
  device->scale = header.device_scale;
  NodeOptions options;
  options.peer = header.peer;
  options.peer.law = *std::move(law);
  options.peer.observer = replay->tap_.get();
  options.name = header.name;
  options.workers = workers;
  replay->node_ =
      std::make_unique<PeerNode>(std::move(model), std::move(device), header.scene_hash, options);
  return replay;
}

std::uint64_t Replay::Run(const RecordedFrame& frame) {
  // each frame drains the queues, so all messages of a recorded frame go into them
  PeerInbox& inbox = node_->inbox();
  for (const MembershipChange& change : frame.changes) {
    TANDEM_CHECK(inbox.membership().TryPush(change));
  }
  for (const Event& event : frame.events) TANDEM_CHECK(inbox.events().TryPush(event));
  for (const Command& command : frame.commands) {
    TANDEM_CHECK(node_->peer().commands().TryPush(command));
  }
  // a peer that stood still, or whose network held samples back, may have taken more at once
  inbox.states().Reserve(frame.states.size());
  inbox.links().Reserve(frame.links.size());
  for (const ObjectState& state : frame.states) {
    TANDEM_CHECK(inbox.states().Push(frame.now_ns, state));
  }
  for (const CouplingLinks& links : frame.links) {
    TANDEM_CHECK(inbox.links().Push(frame.now_ns, links));
  }
  device_->now = frame.device;
  node_->peer().SetCapacity(frame.capacity);
  node_->HapticFrame(frame.now_ns);
  return tap_->hash;
}

ReplayResult RunAll(
    RecordingReader& reader, Replay& replay,
    const std::function<bool(std::int64_t number, const RecordedFrame&)>& after_frame) {
  ReplayResult result;
  while (const std::optional<RecordedFrame> frame = reader.Next()) {
    result.recorded_hash = frame->state_hash;
    result.replayed_hash = replay.Run(*frame);
    if (result.replayed_hash != result.recorded_hash) {
      result.first_different = result.frames;
      return result;
    }
    if (after_frame && !after_frame(result.frames, *frame)) return result;
    ++result.frames;
  }
  return result;
}

}  // namespace tandem
