#include "engine/haptics/process_device.h"

#include <algorithm>

namespace tandem {
namespace {

// returns whether a ramp-in ends the state without a person's consent
bool EndsByItself(SafetyState state) {
  return state == SafetyState::kOff || state == SafetyState::kExpired ||
         state == SafetyState::kOverrun || state == SafetyState::kSuspended;
}

}  // namespace

ProcessDevice::ProcessDevice(DeviceMemory& memory) noexcept
    : memory_(&memory), capabilities_(AsCapabilities(memory.capabilities)),
      every_(static_cast<int>(std::clamp<std::int64_t>(memory.period_ns / kFrameNs, 1, 4))) {
  silent_ = kSilent * every_;
  // the guard of the process knows the user's setting: this device must not ask for more
  capabilities_.peak = {memory.limits[0], memory.limits[1]};
  handle_.X_WA = AsPose(memory.home);
}

void ProcessDevice::Start() noexcept {
  order_.started = 1;
  ++order_.ramps;
}

Anchor ProcessDevice::Read() noexcept {
  const std::uint64_t before = tick_.tick;
  const std::uint32_t rung = memory_->tick_bell.rings();
  bool fresh = memory_->tick.Read(tick_) && tick_.tick != before;
  // a slow device has a tick only in every second frame, for example: the other frames use the last
  // one
  since_ = std::min(since_ + 1, every_);
  const bool due = since_ == every_;
  if (!fresh && due && silent_ < kSilent * every_) {
    memory_->tick_bell.WaitFor(rung, kWaitNs, kSpinNs);
    fresh = memory_->tick.Read(tick_) && tick_.tick != before;
  }
  if (!fresh && !due) return handle_;
  if (!fresh) {
    silent_ = std::min(silent_ + 1, 1'000'000);
    calm_ = 0;
    if (silent_ >= kSilent * every_) handle_.V_WA = {};
    return handle_;
  }
  silent_ = since_ = 0;
  handle_.X_WA = AsPose(tick_.X_WD);
  const auto& V = tick_.V_WD;
  handle_.V_WA = {Vec3(V[0], V[1], V[2]), Vec3(V[3], V[4], V[5])};
  const bool rests = order_.started != 0 && EndsByItself(static_cast<SafetyState>(tick_.state));
  calm_ = rests ? calm_ + 1 : 0;
  if (calm_ >= kCalmFrames) {
    ++order_.ramps;
    calm_ = 0;
  }
  return handle_;
}

void ProcessDevice::Render(const Wrench& F_D_W) noexcept {
  order_.tick = tick_.tick;
  order_.input_ns = tick_.input_ns;
  for (int i = 0; i < 3; ++i) {
    order_.F_D_W[static_cast<std::size_t>(i)] = F_D_W.tau[i];
    order_.F_D_W[static_cast<std::size_t>(3 + i)] = F_D_W.f[i];
  }
  memory_->order.Write(order_);
  memory_->order_bell.Ring();
}

void ProcessDevice::Stop() noexcept {
  ++order_.stops;
}

void ProcessDevice::Resume() noexcept {
  ++order_.resumes;
}

}  // namespace tandem
