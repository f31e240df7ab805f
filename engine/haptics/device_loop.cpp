#include "engine/haptics/device_loop.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tandem {
namespace {

MotorGuard::Options GuardOptions(const Device& driver, const DeviceLoop::Options& options) {
  const DeviceCapabilities can = driver.capabilities();
  MotorGuard::Options guard;
  guard.limits = ValidLimits(can.peak, options.users);
  guard.continuous = can.continuous;
  // a device without motors gets the force too: a handle moved by a rate yields to it, and would
  // run ahead of the part if a user's low limit cut it off
  if (can.freedoms_out == 0) {
    guard.limits = guard.continuous =
        ValidLimits({std::max(options.users.force, kUsersDefault.force),
                     std::max(options.users.moment, kUsersDefault.moment)});
  }
  guard.damping = std::min(MotorGuard::kDamping, ValidGain(can.damping));
  guard.period_ns = DeviceLoop::PeriodOf(can.rate_hz);
  guard.passivity_control = options.passivity_control;
  return guard;
}

void WaitForBell(void* of, std::uint32_t seen, std::int64_t until_ns) {
  static_cast<DeviceMemory*>(of)->order_bell.WaitBeyond(seen, until_ns, DeviceLoop::kSpinNs);
}

}  // namespace

std::int64_t DeviceLoop::PeriodOf(double rate_hz) noexcept {
  if (!(rate_hz > 0)) return kPeriodNs;
  // whole periods of the frames, so that a tick's deadline is also a frame's; slightly less than a
  // whole number counts as one
  const double periods = std::ceil(1e9 / rate_hz / static_cast<double>(kPeriodNs) - 0.01);
  const auto most = static_cast<double>(MotorGuard::kMostPeriodNs / kPeriodNs);
  return static_cast<std::int64_t>(std::clamp(periods, 1.0, most)) * kPeriodNs;
}

std::string DescribeRateChange(const std::string& who, double rate_hz) {
  char text[160];
  if (!(rate_hz > 0)) {
    std::snprintf(text, sizeof text,
                  ": a rate of %g Hz is none: it is written to 1000 times a second", rate_hz);
    return who + text;
  }
  const std::int64_t period_ns = DeviceLoop::PeriodOf(rate_hz);
  // too slow by more than the rounding of PeriodOf
  if (1e9 / rate_hz <= 1.01 * static_cast<double>(period_ns)) return {};
  std::snprintf(
      text, sizeof text,
      ": its %g Hz are too slow for the limits on old forces: it is written to %g times a "
      "second",
      rate_hz, 1e9 / static_cast<double>(period_ns));
  return who + text;
}

DeviceLoop::DeviceLoop(Device& driver, DeviceMemory& memory, LoopClock& clock,
                       const Options& options)
    : driver_(&driver),
      memory_(&memory),
      clock_(&clock),
      period_ns_(PeriodOf(driver.capabilities().rate_hz)),
      has_motors_(driver.capabilities().freedoms_out > 0),
      guard_(GuardOptions(driver, options)),
      wait_(&WaitForBell),
      wait_of_(&memory) {
  memory.capabilities = AsNumbers(driver.capabilities());
  memory.limits = {guard_.limits().force, guard_.limits().moment};
  memory.period_ns = period_ns_;
}

void DeviceLoop::PublishTick(const Anchor& handle) noexcept {
  tick_.X_WD = AsNumbers(handle.X_WA);
  const Twist& V = handle.V_WA;
  tick_.V_WD = {V.w[0], V.w[1], V.w[2], V.v[0], V.v[1], V.v[2]};
  tick_.state = static_cast<std::uint8_t>(guard_.state());
  tick_.failed = driver_->failed();
  tick_.clutch_button = driver_->clutch_button();
  tick_.counts = guard_.counts();
  const PassivityObserver& port = guard_.passivity();
  tick_.passivity = {guard_.passivity_control(), port.balance_J(), port.least_J(), guard_.damped()};
  memory_->tick.Write(tick_);
  memory_->tick_bell.Ring();
}

bool DeviceLoop::TakeOrder() noexcept {
  DeviceOrder order;
  if (!memory_->order.Read(order)) return false;
  answers_ = order.tick;
  order_.input_ns = order.tick == 0 ? -1 : order.input_ns;
  // an order that claims to answer a future tick must not stay fresh for ever
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

void DeviceLoop::Tick(const TickConditions& now) noexcept {
  ++tick_.tick;
  // read before the handle: a driver that answers slowly gives an old handle
  tick_.input_ns = clock_->NowNs();
  const Anchor handle = driver_->Read();
  std::uint32_t seen = memory_->order_bell.rings();
  PublishTick(handle);

  const bool first = answers_ == 0;  // it answers a tick for which no wait was made
  bool answered = TakeOrder();
  // the bell may ring for an answer to an earlier tick: waits on for this one
  while (!answered) {
    // does not wait for an order that is too old to be used, or for a controller that has not begun
    const std::int64_t until_ns =
        std::min(now.deadline_ns + kWaitNs, MotorGuard::ExpiryOf(order_.input_ns));
    if (clock_->NowNs() >= until_ns) break;
    wait_(wait_of_, seen, until_ns);
    seen = memory_->order_bell.rings();
    answered = TakeOrder();
  }

  MotorInput input;
  input.now_ns = clock_->NowNs();
  input.p_WD = handle.X_WA.p;
  input.V_WD = handle.V_WA;
  // trouble takes no force from a device without motors: that would make no person safer, and the
  // handle would run ahead of the part until a person resumes
  input.failed = tick_.failed && has_motors_;
  input.stop_button = driver_->stop_button();
  input.ending = now.ending;
  input.slept = now.slept;
  given_ = guard_.Pass(input, order_);
  driver_->Render(given_);

  Count(answered, first);
  if (last_deadline_ns_ != 0 && now.deadline_ns > last_deadline_ns_) {
    missed_ += static_cast<std::uint64_t>((now.deadline_ns - last_deadline_ns_) / period_ns_ - 1);
  }
  last_deadline_ns_ = now.deadline_ns;
  if (tick_.tick % kTellEvery == 0) PublishTimes();
}

void DeviceLoop::Count(bool answered, bool first) noexcept {
  if (answered) ++answered_;
  if (!answered && answers_ != 0) ++unanswered_;
  if (answers_ == counted_) return;
  counted_ = answers_;
  if (first || order_.input_ns < 0) return;
  if (!answered) ++late_;
  read_to_write_.Add(clock_->NowNs() - order_.input_ns);
}

DeviceTimes DeviceLoop::times() const noexcept {
  const ForceFetchTimes requested = driver_->fetch_times();
  return {.ticks = tick_.tick,
          .answered = answered_,
          .unanswered = unanswered_,
          .late = late_,
          .missed = missed_,
          .read_to_write_p50_ns = read_to_write_.Quantile(0.5),
          .read_to_write_p99_ns = read_to_write_.Quantile(0.99),
          .read_to_write_max_ns = read_to_write_.max(),
          .requested = requested.count,
          .asked_mean_ns = requested.mean_ns,
          .asked_max_ns = requested.max_ns};
}

}  // namespace tandem
