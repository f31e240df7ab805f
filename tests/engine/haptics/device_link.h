#pragma once

#include <cmath>
#include <cstdint>
#include <memory>

#include "engine/haptics/device_loop.h"
#include "engine/haptics/process_device.h"

namespace tandem::testing {

inline constexpr std::int64_t kPeriod = DeviceLoop::kPeriodNs;

class HandClock : public LoopClock {
 public:
  std::int64_t NowNs() noexcept override { return now_ns; }
  std::int64_t ThreadCpuNs() noexcept override { return now_ns; }
  void SleepUntil(std::int64_t deadline_ns) noexcept override { now_ns = deadline_ns; }
  std::int64_t now_ns = kPeriod;
};

/// A handle that goes a micrometre a tick, so that a force tells which tick it answers.
class CountingDriver : public Device {
 public:
  void Start() noexcept override { started = true; }
  Anchor Read() noexcept override {
    Anchor handle;
    handle.X_WA.p.x() = 1e-6 * ++reads;
    if (clock != nullptr) clock->now_ns += read_ns;
    return handle;
  }
  void Render(const Wrench& F_D_W) noexcept override { given = F_D_W; }
  void Stop() noexcept override { given = {}; }
  DeviceCapabilities capabilities() const noexcept override { return can; }
  bool failed() const noexcept override { return in_trouble; }

  DeviceCapabilities can;
  Wrench given;
  int reads = 0;
  HandClock* clock = nullptr;  // clock of which its reads take time; null: they take none
  std::int64_t read_ns = 0;
  bool started = false;
  bool in_trouble = false;
};

/// Both ends. The controller answers within the wait of a tick, a quarter of a millisecond later.
class Link {
 public:
  explicit Link(double rate_hz = 1000, int motors = 6) : memory(std::make_unique<DeviceMemory>()) {
    driver.can.rate_hz = rate_hz;
    driver.can.freedoms_out = motors;
    loop = std::make_unique<DeviceLoop>(driver, *memory, clock, DeviceLoop::Options{{12, 0.5}});
    controller = std::make_unique<ProcessDevice>(*memory);
    loop->SetWait(
        [](void* of, std::uint32_t, std::int64_t until_ns) {
          static_cast<Link*>(of)->WhileWaiting(until_ns);
        },
        this);
  }
  void Tick(bool alive = true) {
    answers = alive;
    answered = false;
    const std::int64_t deadline_ns = clock.now_ns;
    loop->Tick({.deadline_ns = deadline_ns});
    if (alive && !answered) Answer();  // it was not waited for
    // the controller's other frames before the next tick of a slow device
    for (std::int64_t ns = kPeriod; alive && ns < loop->period_ns(); ns += kPeriod) {
      clock.now_ns = deadline_ns + ns;
      Answer();
    }
    clock.now_ns = deadline_ns + loop->period_ns();
  }
  void Ticks(int count, bool alive = true) {
    for (int i = 0; i < count; ++i) Tick(alive);
  }
  void Begin() {
    Ticks(3);
    controller->Start();
    Ticks(1200);
  }
  SafetyState state() const { return loop->guard().state(); }

  HandClock clock;
  CountingDriver driver;
  std::unique_ptr<DeviceMemory> memory;
  std::unique_ptr<DeviceLoop> loop;
  std::unique_ptr<ProcessDevice> controller;
  double force_at_micrometre = 1;  // N
  bool answers = true;
  bool answered = false;
  std::int64_t answer_ns = kPeriod / 4;  // time that an answer takes
  bool stray_ring = false;               // before each answer, the bell rings for nothing new

 private:
  void WhileWaiting(std::int64_t until_ns) {
    if (NextIsStray()) {
      memory->order_bell.Ring();
    } else if (answers && clock.now_ns + answer_ns <= until_ns) {
      clock.now_ns += answer_ns;
      Answer();
    } else {
      clock.now_ns = until_ns;
    }
  }
  /// Returns whether the next ring is stray: every second one is, where there are stray ones.
  bool NextIsStray() {
    stray_ = stray_ring && !stray_;
    return stray_;
  }
  bool stray_ = false;
  void Answer() {
    answered = true;
    const Anchor handle = controller->Read();
    Wrench force;
    // the force tells the tick's last three digits
    force.f.x() = force_at_micrometre * 1e-3 * std::fmod(std::round(1e6 * handle.X_WA.p.x()), 1000);
    controller->Render(force);
  }
};

}  // namespace tandem::testing
