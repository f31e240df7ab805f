#include "collab/simulated/hands/device_rig.h"

#include <limits>
#include <utility>

#include "collab/simulated/hands/planted_hand_faults.h"

namespace tandem {

namespace {
constexpr std::int64_t kAnswerNs = 250'000;  // time of the controller's answer
}

DeviceRig::DeviceRig(std::uint64_t seed, PeerId id, Breakages& breakages)
    : hand_(seed),
      memory_(std::make_unique<DeviceMemory>()),
      loop_(std::make_unique<DeviceLoop>(driver_, *memory_, clock_, DeviceLoop::Options{})),
      checker_(id, kUsersDefault, breakages) {
  memory_->home = AsNumbers(Pose{});
  loop_->SetWait(
      [](void* of, std::uint32_t, std::int64_t until_ns) {
        static_cast<DeviceRig*>(of)->Wait(until_ns);
      },
      this);
}

bool DeviceRig::Tick(std::int64_t now_ns, const std::function<void()>& answer) {
  if (halted(now_ns)) return false;
  clock_.now_ns = now_ns;
  answer_ = &answer;
  slept_now_ = std::exchange(slept_, false);
  loop_->Tick({.deadline_ns = now_ns, .ending = ending_, .slept = slept_now_});
  return std::exchange(answer_, nullptr) == nullptr;
}

void DeviceRig::Wait(std::int64_t until_ns) {
  DeviceOrder before;
  const bool known = memory_->order.Read(before);
  if (const auto* answer = std::exchange(answer_, nullptr)) (*answer)();
  DeviceOrder after;
  const bool answered = memory_->order.Read(after) && (!known || after.tick != before.tick);
  clock_.now_ns = answered ? std::min(clock_.now_ns + kAnswerNs, until_ns) : until_ns;
}

void DeviceRig::Given(const Wrench& F_D_W) {
  ++ticks_;
  MotorTick tick;
  tick.now_ns = clock_.now_ns;
  tick.V_WD = hand_.handle().V_WA;
  tick.sound = !hand_.fails && !hand_.nonsense;
  tick.button = hand_.pressed;
  tick.ending = ending_;
  tick.slept = slept_now_;
  DeviceOrder order;
  if (memory_->order.Read(order)) {
    if (order.tick > 0) tick.input_ns = order.input_ns;
    tick.ramps = order.ramps;
    tick.stops = order.stops;
    tick.resumes = order.resumes;
  }
  tick.given = Spoilt(F_D_W, tick);
  checker_.Look(tick);
  hand_.Render(F_D_W);
}

Wrench DeviceRig::Spoilt(const Wrench& F_D_W, const MotorTick& tick) {
  const std::int64_t age_ns = tick.now_ns - tick.input_ns;
  const bool fresh = tick.input_ns >= 0 && age_ns < MotorGuard::kDampingNs;
  if (fresh) kept_ = {F_D_W.tau, F_D_W.f + Vec3(0, 0, 0.3)};
  const bool too_fast = tick.V_WD.v.norm() > MotorGuard::kMostSpeed;
  if (PlantedInHand(HandFault::kMotorTenfold)) return {10 * F_D_W.tau, 10 * F_D_W.f};
  if (PlantedInHand(HandFault::kMotorJumps))
    return ticks_ % 2 == 0 ? F_D_W : Wrench{-F_D_W.tau, -F_D_W.f};
  if (PlantedInHand(HandFault::kMotorNoNumber) && ticks_ > 500) {
    return {F_D_W.tau, Vec3::Constant(std::numeric_limits<double>::quiet_NaN())};
  }
  if (PlantedInHand(HandFault::kMotorKeeps) && !fresh) return kept_;
  if (PlantedInHand(HandFault::kMotorPushesOn) && !fresh) {
    return {F_D_W.tau, -F_D_W.f + 0.2 * tick.V_WD.v};
  }
  if (PlantedInHand(HandFault::kMotorAfterStop) && state() == SafetyState::kStopped) return kept_;
  if (PlantedInHand(HandFault::kMotorAfterFault) && state() == SafetyState::kFault) return kept_;
  if (PlantedInHand(HandFault::kMotorAtOnce) && tick.ramps == 0)
    return {Vec3(0, 0, 0), Vec3(0, 0, 0.3)};
  if (PlantedInHand(HandFault::kMotorAtOnce) && !fresh) kept_ = {};
  if (PlantedInHand(HandFault::kMotorAtOnce) && fresh && state() != SafetyState::kOn) return kept_;
  if (PlantedInHand(HandFault::kMotorTooFast) && too_fast) return kept_;
  return F_D_W;
}

}  // namespace tandem
