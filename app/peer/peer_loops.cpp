#include "app/peer/peer_loops.h"

#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::int64_t kHapticPeriodNs = 1'000'000;
constexpr std::int64_t kPoseFrames = 5;  // frames from one pose that is judged to the next

std::optional<CapacityFollower> FollowerOf(const PeerArguments& arguments,
                                           const FrameCapacity& measured) {
  if (arguments.capacity != 0) return std::nullopt;
  return CapacityFollower(measured.tests, measured.query_price, kFrameBudget);
}

}  // namespace

PeerLoops::PeerLoops(const PeerArguments& arguments, const SessionSetup& setup,
                     PeerControl* control)
    : node_(*setup.node),
      transport_(*setup.transport),
      control_(control),
      frames_(static_cast<std::int64_t>(arguments.seconds * 1000.0)),
      capacity_(FollowerOf(arguments, setup.capacity)),
      held_poses_(256),
      met_(setup.model->bodies.size()),
      // a device's ticks and our frames begin together
      origin_ns_(setup.device() != nullptr ? setup.device()->origin_ns() : MonotonicNowNs()),
      judged_(origin_ns_, kHapticPeriodNs),
      haptic_(
          {.period_ns = kHapticPeriodNs,
           .origin_ns = origin_ns_,
           .core = arguments.core,
           .name = "haptic"},
          [this](std::int64_t, std::int64_t now_ns) {
            kHapticThread.Enter();
            Frame(now_ns);
            return true;
          },
          [this](std::int64_t start_ns, std::int64_t end_ns, std::int64_t cpu_ns) {
            CountFrame(start_ns, end_ns, cpu_ns);
          }),
      no_more_force_([this] {
        haptic_.Stop();
      }),
      sender_({.origin_ns = origin_ns_ + kSenderPhaseNs, .priority = 20, .name = "sender"},
              [this](std::int64_t, std::int64_t) {
                kSenderThread.Enter();
                SendWhenDone(node_, transport_, MachineClock());
                return true;
              }) {}

void PeerLoops::Frame(std::int64_t now_ns) {
  if (capacity_) node_.peer().SetCapacity(capacity_->tests());
  if (control_ != nullptr) control_->BeforeFrame();
  node_.HapticFrame(now_ns);
  if (control_ != nullptr) control_->AfterFrame(now_ns);
  hand_moves_ = node_.peer().started_ns() && (frames_ == 0 || frames_since_start_ < frames_);
  if (node_.peer().started_ns()) SeeHand();
}

void PeerLoops::SeeHand() {
  if (const RigidState* held = node_.peer().held_state(); held != nullptr) {
    const int body = HeldBody(node_);
    met_.See(node_.world(), body);
    holds_.store(true, std::memory_order_relaxed);
    // a full queue loses the pose: then fewer poses judge the run
    if (frames_since_start_ % kPoseFrames == 0) {
      static_cast<void>(held_poses_.TryPush({.body = body, .X_WB = held->X_WB}));
    }
  }
  begun_.store(true, std::memory_order_relaxed);
  if (++frames_since_start_ == frames_) done_.store(true, std::memory_order_release);
}

void PeerLoops::CountFrame(std::int64_t start_ns, std::int64_t end_ns, std::int64_t cpu_ns) {
  const StepReport& report = node_.peer().report();
  if (capacity_ && report.waited == 0) {
    capacity_->Count(report, ToSeconds(cpu_ns));
  }
  judged_.Add(hand_moves_, start_ns, end_ns, cpu_ns);
}

void PeerLoops::TakePoses(HeldPoses& poses) {
  HeldPose pose;
  while (held_poses_.TryPop(pose)) poses.Add(pose);
}

void PeerLoops::EndHaptic() {
  haptic_.Stop();
  haptic_.Join();
}

void PeerLoops::EndSender() {
  sender_.Stop();
  sender_.Join();
}

}  // namespace tandem
