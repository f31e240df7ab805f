#include "collab/simulated/hands/simulated_device_process.h"

#include <utility>

namespace tandem {

namespace {
constexpr std::int64_t kAnswerNs = 250'000;  // time of the controller's answer
}

SimulatedDeviceProcess::SimulatedDeviceProcess(std::uint64_t seed, PeerId id,
                                               Violations& violations)
    : hand_(seed),
      memory_(std::make_unique<DeviceMemory>()),
      loop_(std::make_unique<DeviceLoop>(driver_, *memory_, clock_, DeviceLoop::Options{})),
      checker_(id, kUsersDefault, violations) {
  memory_->home = AsNumbers(Pose{});
  loop_->SetWait(
      [](void* of, std::uint32_t, std::int64_t until_ns) {
        static_cast<SimulatedDeviceProcess*>(of)->Wait(until_ns);
      },
      this);
}

bool SimulatedDeviceProcess::Tick(std::int64_t now_ns, const std::function<void()>& answer) {
  if (halted(now_ns)) return false;
  clock_.now_ns = now_ns;
  answer_ = &answer;
  slept_now_ = std::exchange(slept_, false);
  loop_->Tick({.deadline_ns = now_ns, .ending = ending_, .slept = slept_now_});
  return std::exchange(answer_, nullptr) == nullptr;
}

void SimulatedDeviceProcess::Wait(std::int64_t until_ns) {
  DeviceOrder before;
  const bool known = memory_->order.Read(before);
  if (const auto* answer = std::exchange(answer_, nullptr)) (*answer)();
  DeviceOrder after;
  const bool answered = memory_->order.Read(after) && (!known || after.tick != before.tick);
  clock_.now_ns = answered ? std::min(clock_.now_ns + kAnswerNs, until_ns) : until_ns;
}

void SimulatedDeviceProcess::Given(const Wrench& F_D_W) {
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
  tick.given = F_D_W;
  checker_.Check(tick);
  hand_.Render(F_D_W);
}

}  // namespace tandem
