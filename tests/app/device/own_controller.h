#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "app/process/child_processes.h"
#include "app/process/device_process.h"
#include "engine/realtime/periodic_thread.h"
#include "tests/app/device/motor_writes.h"

namespace tandem::testing {

/// Runs a device process whose controller is the test.
class OwnController {
 public:
  explicit OwnController(const std::string& options, const DeviceLimits& users = kUsersDefault)
      : motor_file_(folder_.path() / "motor"), motor(motor_file_) {
    Result<std::unique_ptr<DeviceProcess>> started = DeviceProcess::Start(
        {.driver = "fake:record=" + motor_file_.string() + options, .users = users});
    EXPECT_TRUE(started) << started.error().what;
    process = *std::move(started);
    device = process->MakeDevice();
    wanted.f.x() = 2.5;
  }
  /// Runs the controller for so many frames.
  void Run(int frames) {
    PeriodicThread thread({.origin_ns = process->origin_ns()},
                          [&](std::int64_t frame, std::int64_t) {
                            device->Read();
                            device->Render(wanted);
                            return frame + 1 < frames;
                          });
    thread.Join();
  }
  /// Returns the largest force, and the largest change between two writes of a loop in time.
  Fall All() const { return FallAfter(motor.WritesSince(0), MonotonicNowNs()); }
  SafetyState state() const {
    return static_cast<SafetyState>(process->Newest().value_or(DeviceTick{}).state);
  }

 private:
  TemporaryFolder folder_;
  std::filesystem::path motor_file_;

 public:
  Motor motor;
  std::unique_ptr<DeviceProcess> process;
  std::unique_ptr<Device> device;
  Wrench wanted;
};

/// Runs a controller for so many frames, in which the force comes to `rise_N` before whatever the
/// test waits for happens. A machine that stands still for 20 ms takes the force away and its ramp
/// begins anew; such a run shows nothing, and another one is tried.
inline std::unique_ptr<OwnController> RunWithForce(double rise_N, int frames,
                                                   const std::string& options,
                                                   double wanted_N = 2.5,
                                                   const DeviceLimits& users = kUsersDefault) {
  for (int tries = 0; tries < 6; ++tries) {
    auto own = std::make_unique<OwnController>(options, users);
    own->wanted.f.x() = wanted_N;
    own->device->Start();
    own->Run(frames);
    if (own->All().most >= rise_N) return own;
  }
  ADD_FAILURE() << "no force of " << rise_N << " N in any of six runs with '" << options << "'";
  return std::make_unique<OwnController>(options, users);
}

/// A controller that goes on with frames while the test does something to the device process.
class RunningController : public OwnController {
 public:
  explicit RunningController(const std::string& options) : OwnController(options) {
    device->Start();
    thread_ =
        std::make_unique<PeriodicThread>(PeriodicThread::Options{.origin_ns = process->origin_ns()},
                                         [this](std::int64_t, std::int64_t) {
                                           device->Read();
                                           device->Render(wanted);
                                           return true;
                                         });
  }
  ~RunningController() { thread_.reset(); }
  bool WaitForEnd(double seconds = 20) {
    for (int i = 0; i < 200 * seconds; ++i) {
      static_cast<void>(process->News());  // a process that has ended is then gone
      if (kill(process->pid(), 0) != 0) return true;
      Sleep(5e-3);
    }
    return false;
  }

 private:
  std::unique_ptr<PeriodicThread> thread_;
};

}  // namespace tandem::testing
