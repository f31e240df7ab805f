#include "tests/network/in_process_peer.h"

#include <utility>

#include "collab/session/scene_agreement.h"
#include "engine/base/check.h"
#include "engine/haptics/scripted_device.h"
#include "engine/scene/scene_hash.h"

namespace tandem::testing {

void InProcessPeer::Join(const std::string& session, PeerId id) {
  const Result<Scene> scene = LoadScene(std::filesystem::path(TANDEM_SCENES) / "peg_in_slot.json");
  TANDEM_CHECK(scene.has_value());
  const auto hash = HashScene(*scene);
  const auto model = LoadWorld(*scene);
  TANDEM_CHECK(hash.has_value() && model.has_value());
  const int object = scene->BodyNamed("peg");
  NodeOptions options;
  options.peer.id = id;
  options.peer.held_object = object;
  options.name = "own";
  options.manifest = ManifestOf(*scene, *hash, id);
  node_ = std::make_unique<PeerNode>(
      *model, std::make_unique<ScriptedDevice>(HandScript{}, (*model)->bodies[0].X_WB0),
      hash->content, options);
  DdsOptions dds;
  dds.session = session;
  dds.peer = id;
  dds.interface = std::string("lo");
  dds.objects = {static_cast<ObjectId>(object)};
  auto joined = JoinOverDds(dds, node_->inbox());
  TANDEM_CHECK(joined.has_value());
  transport_ = std::move(*joined);
}

InProcessPeer::InProcessPeer(const std::string& session, PeerId id, Stepped) {
  Join(session, id);
  began_ns_ = MonotonicNowNs();
}

InProcessPeer::InProcessPeer(const std::string& session, PeerId id, Frame frame) {
  Join(session, id);
  haptic_ = std::make_unique<PeriodicThread>(
      PeriodicThread::Options{.name = "haptic"},
      [this, frame = std::move(frame)](std::int64_t, std::int64_t now_ns) {
        kHapticThread.Enter();
        frame(*node_, now_ns);
        return true;
      });
  sender_ = std::make_unique<PeriodicThread>(PeriodicThread::Options{.priority = 20},
                                             [this](std::int64_t, std::int64_t now_ns) {
                                               kSenderThread.Enter();
                                               node_->SendFrame(now_ns, *transport_);
                                               return true;
                                             });
}

InProcessPeer::~InProcessPeer() {
  haptic_.reset();
  sender_.reset();
  transport_->Leave();
}

void InProcessPeer::Run(double seconds, const std::function<bool()>& done) {
  constexpr std::int64_t kControlPeriodNs = 20'000'000;
  kControlThread.Enter();
  const std::int64_t until_ns = MonotonicNowNs() + static_cast<std::int64_t>(1e9 * seconds);
  while (!done() && MonotonicNowNs() < until_ns) {
    node_->ControlFrame(MonotonicNowNs(), *transport_);
    MachineClock().SleepUntil(MonotonicNowNs() + kControlPeriodNs);
  }
}

void InProcessPeer::StepFrames(int count) {
  constexpr std::int64_t kPeriodNs = 1'000'000;
  std::int64_t next_ns = MonotonicNowNs();
  for (int i = 0; i < count; ++i) {
    next_ns = std::max(next_ns + kPeriodNs, MonotonicNowNs());
    MachineClock().SleepUntil(next_ns);
    const std::int64_t now_ns = began_ns_ + ++stepped_ * kPeriodNs;
    kHapticThread.Enter();
    node_->HapticFrame(now_ns);
    kSenderThread.Enter();
    node_->SendFrame(now_ns, *transport_);
    kControlThread.Enter();
    if (stepped_ % 20 == 0) node_->ControlFrame(now_ns, *transport_);
  }
}

bool InProcessPeer::StepUntilCoupled() {
  constexpr int kMostFrames = 60'000;
  for (int frame = 0; frame < kMostFrames; ++frame) {
    StepFrames(1);
    const SharedBody* shared = node_->peer().shared();
    if (shared != nullptr && shared->coupled() > 0) return true;
  }
  return false;
}

void InProcessPeer::DefaultFrame(PeerNode& node, std::int64_t now_ns) {
  kHapticThread.Enter();
  node.HapticFrame(now_ns);
}

}  // namespace tandem::testing
