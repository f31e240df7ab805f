#include "engine/haptics/device_loop.h"

#include <algorithm>

namespace tandem {
namespace {

MotorGuard::Options GuardOptions(const Device& driver, const DeviceLoop::Options& options) {
  const DeviceCapabilities can = driver.capabilities();
  MotorGuard::Options guard;
  guard.limits = SoundLimits(can.peak, options.users);
  guard.continuous = can.continuous;
  if (can.freedoms_out == 0) guard.limits = {0, 0};
  guard.damping = std::min(MotorGuard::kDamping, can.damping);
  guard.passivity_control = options.passivity_control;
  return guard;
}

void WaitForBell(void* of, std::uint32_t seen, std::int64_t until_ns) {
  static_cast<DeviceMemory*>(of)->order_bell.WaitBeyond(seen, until_ns, DeviceLoop::kSpinNs);
}

}  // namespace

DeviceLoop::DeviceLoop(Device& driver, DeviceMemory& memory, LoopClock& clock,
                       const Options& options)
    : driver_(&driver),
      memory_(&memory),
      clock_(&clock),
      guard_(GuardOptions(driver, options)),
      wait_(&WaitForBell),
      wait_of_(&memory) {
  memory.capabilities = AsNumbers(driver.capabilities());
  memory.limits = {guard_.limits().force, guard_.limits().moment};
  memory.period_ns = kPeriodNs;
}

void DeviceLoop::Say(const Anchor& handle) noexcept {
  tick_.X_WD = AsNumbers(handle.X_WA);
  const Twist& V = handle.V_WA;
  tick_.V_WD = {V.w[0], V.w[1], V.w[2], V.v[0], V.v[1], V.v[2]};
  tick_.state = static_cast<std::uint8_t>(guard_.state());
  tick_.failed = driver_->failed();
  tick_.clutch_button = driver_->clutch_button();
  tick_.counts = guard_.counts();
  memory_->tick.Write(tick_);
  memory_->tick_bell.Ring();
}

bool DeviceLoop::TakeOrder() noexcept {
  DeviceOrder order;
  if (!memory_->order.Read(order)) return false;
  answers_ = order.tick;
  order_.input_ns = order.tick == 0 ? -1 : order.input_ns;
  // what claims to answer what has not been asked yet is not fresh for ever
  if (order.input_ns > tick_.input_ns) order_.input_ns = -1;
  for (int i = 0; i < 3; ++i) {
    order_.F_D_W.tau[i] = order.F_D_W[static_cast<std::size_t>(i)];
    order_.F_D_W.f[i] = order.F_D_W[static_cast<std::size_t>(3 + i)];
  }
  order_.ramps = order.ramps;
  order_.stops = order.stops;
  order_.resumes = order.resumes;
  if (order.started != 0 && !started_) {
    started_ = true;
    driver_->Start();
  }
  return answers_ == tick_.tick;
}

void DeviceLoop::Tick(const Circumstances& now) noexcept {
  ++tick_.tick;
  const Anchor handle = driver_->Read();
  tick_.input_ns = clock_->NowNs();
  const std::uint32_t seen = memory_->order_bell.rings();
  Say(handle);

  bool answered = TakeOrder();
  // nobody waits for what is too old to be used, or for a controller that has not begun
  const std::int64_t until_ns =
      std::min(now.deadline_ns + kWaitNs, MotorGuard::ExpiryOf(order_.input_ns));
  if (!answered && clock_->NowNs() < until_ns) {
    wait_(wait_of_, seen, until_ns);
    answered = TakeOrder();
  }

  MotorInput input;
  input.now_ns = clock_->NowNs();
  input.p_WD = handle.X_WA.p;
  input.V_WD = handle.V_WA;
  input.failed = tick_.failed;
  input.stop_button = driver_->stop_button();
  input.ending = now.ending;
  input.slept = now.slept;
  given_ = guard_.Pass(input, order_);
  driver_->Render(given_);

  if (answered) {
    ++answered_;
    read_to_write_.Add(clock_->NowNs() - tick_.input_ns);
  } else if (answers_ != 0) {
    ++unanswered_;
  }
  if (last_deadline_ns_ != 0 && now.deadline_ns > last_deadline_ns_) {
    missed_ += static_cast<std::uint64_t>((now.deadline_ns - last_deadline_ns_) / kPeriodNs - 1);
  }
  last_deadline_ns_ = now.deadline_ns;
  if (tick_.tick % kTellEvery == 0) Tell();
}

DeviceTimes DeviceLoop::times() const noexcept {
  return {.ticks = tick_.tick,
          .answered = answered_,
          .unanswered = unanswered_,
          .missed = missed_,
          .read_to_write_p50_ns = read_to_write_.Quantile(0.5),
          .read_to_write_p99_ns = read_to_write_.Quantile(0.99),
          .read_to_write_max_ns = read_to_write_.max()};
}

}  // namespace tandem
