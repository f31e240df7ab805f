#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "collab/simulated/hands/checkers/motor_checker.h"
#include "collab/simulated/hands/modelled_hand.h"
#include "engine/haptics/device_loop.h"
#include "engine/haptics/process_device.h"

namespace tandem {

/// A device process in virtual time: its loop, the motor guard, the driver with a modelled hand,
/// and the memory that it shares with a controller. It shows each tick to a checker.
class SimulatedDeviceProcess {
 public:
  SimulatedDeviceProcess(std::uint64_t seed, PeerId id, Violations& violations);

  /// Returns the controller's end.
  std::unique_ptr<Device> MakeDevice() { return std::make_unique<ProcessDevice>(*memory_); }

  /// Runs a tick that is due at `now_ns`. Where the loop waits for the controller's answer it calls
  /// `answer`, at most once, which may give one. Returns whether it called it.
  bool Tick(std::int64_t now_ns, const std::function<void()>& answer);

  /// Halts the process until that time, as by SIGSTOP, or because the machine sleeps.
  void Halt(std::int64_t until_ns, bool sleeps) {
    halted_until_ns_ = until_ns;
    slept_ = sleeps;
  }
  bool halted(std::int64_t now_ns) const { return now_ns < halted_until_ns_; }
  /// Ends the process, whose parent is gone. The motor then gets no force.
  void End() { ending_ = true; }
  ModelledHand& hand() { return hand_; }
  SafetyState state() const { return loop_->guard().state(); }

 private:
  class Clock : public LoopClock {
   public:
    std::int64_t NowNs() noexcept override { return now_ns; }
    std::int64_t ThreadCpuNs() noexcept override { return now_ns; }
    void SleepUntil(std::int64_t deadline_ns) noexcept override { now_ns = deadline_ns; }
    std::int64_t now_ns = 0;
  };
  /// The driver as the loop has it. It shows the checker the motor's wrench.
  class Driver : public Device {
   public:
    explicit Driver(SimulatedDeviceProcess& rig) : rig_(&rig) {}
    void Start() noexcept override {}
    Anchor Read() noexcept override { return rig_->hand_.Read(); }
    void Render(const Wrench& F_D_W) noexcept override { rig_->Given(F_D_W); }
    DeviceCapabilities capabilities() const noexcept override { return rig_->hand_.capabilities(); }
    bool failed() const noexcept override { return rig_->hand_.failed(); }
    bool stop_button() const noexcept override { return rig_->hand_.stop_button(); }

   private:
    SimulatedDeviceProcess* rig_;
  };

  void Wait(std::int64_t until_ns);
  void Given(const Wrench& F_D_W);

  ModelledHand hand_;
  Driver driver_{*this};
  Clock clock_;
  std::unique_ptr<DeviceMemory> memory_;
  std::unique_ptr<DeviceLoop> loop_;
  MotorChecker checker_;
  const std::function<void()>* answer_ = nullptr;  // callback of this tick; null: it was called
  std::int64_t halted_until_ns_ = 0;
  bool slept_ = false;      // the machine slept since the last tick
  bool slept_now_ = false;  // the machine slept before the present tick
  bool ending_ = false;
};

}  // namespace tandem
