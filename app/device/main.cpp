// The process that has a device in hand. A controller (`tandem peer --device`) starts it and shares
// memory with it; nothing that becomes of the controller leaves a force at the motor.
#include <atomic>
#include <cstdio>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "app/device/device_watch.h"
#include "app/device/drivers.h"
#include "app/exit_codes.h"
#include "app/option_checks.h"
#include "engine/haptics/device_loop.h"
#include "engine/realtime/periodic_thread.h"
#include "engine/realtime/shared_memory.h"

namespace tandem {
namespace {

constexpr int kPriority = 40;  // above all of the controller: the motor is served first
constexpr std::int64_t kSleptEnoughNs = 10'000'000;
constexpr std::int64_t kGiveUpNs = 1'000'000'000;  // for a driver that hangs, Stop() and all

struct DeviceArguments {
  std::string driver;
  int memory = -1;
  DeviceLimits users = kUsersDefault;
  bool passivity_control = false;
  int core = -1;
  bool list = false;
};

int FailWith(DeviceMemory& memory, const std::string& why) {
  std::snprintf(memory.fault.data(), memory.fault.size(), "%s", why.c_str());
  memory.ready.store(DeviceMemory::kFailed, std::memory_order_release);
  return kExitDevice;
}

int Serve(const DeviceArguments& arguments) {
  const pid_t controller = getppid();
  Result<SharedMemory> shared = SharedMemory::Attach(arguments.memory, sizeof(DeviceMemory));
  if (!shared) {
    std::fprintf(stderr, "tandem-device: %s; 'tandem peer --device' starts it\n",
                 shared.error().what.c_str());
    return kExitDevice;
  }
  auto& memory = *static_cast<DeviceMemory*>(shared->data());
  if (memory.version != DeviceMemory::kVersion) {
    return FailWith(memory, "tandem-device is of another version than the program that started it");
  }
  DeviceWatch watch(controller, kPriority + 1);
  Result<std::unique_ptr<Device>> driver = OpenDriver(arguments.driver, AsPose(memory.home));
  if (!driver) return FailWith(memory, driver.error().what);
  DeviceLoop loop(**driver, memory, MachineClock(),
                  {.users = arguments.users, .passivity_control = arguments.passivity_control});
  const std::int64_t origin_ns = MonotonicNowNs();
  memory.origin_ns = origin_ns;
  std::int64_t slept_ns = SleptNs();
  std::atomic<bool> ended{false};
  watch.Guard(**driver);
  PeriodicThread thread(
      {.period_ns = loop.period_ns(),
       .origin_ns = origin_ns,
       .priority = kPriority,
       .core = arguments.core,
       .name = "device"},
      [&](std::int64_t tick, std::int64_t now_ns) {
        if (tick == 0) watch.EnterLoop();
        if (!watch.BeginTick()) return false;
        const std::int64_t slept_now_ns = SleptNs();
        // here too, for the watch may wait for long on a busy machine
        const bool ends = watch.ending() || getppid() != controller;
        loop.Tick({.deadline_ns = now_ns - (now_ns - origin_ns) % loop.period_ns(),
                   .ending = ends,
                   .slept = slept_now_ns - slept_ns > kSleptEnoughNs});
        slept_ns = slept_now_ns;
        watch.EndTick();
        const bool goes_on = !(ends && loop.at_rest());
        if (!goes_on) ended.store(true);
        return goes_on;
      });
  const RealtimeStatus& status = thread.realtime();
  std::snprintf(memory.scheduler.data(), memory.scheduler.size(), "%s", status.scheduler());
  std::snprintf(memory.warning.data(), memory.warning.size(), "%s", status.warning.c_str());
  memory.ready.store(DeviceMemory::kReady, std::memory_order_release);
  std::int64_t ends_ns = 0;
  while (!ended.load()) {
    MachineClock().SleepUntil(MonotonicNowNs() + DeviceWatch::kLookNs);
    if (watch.ending() && ends_ns == 0) ends_ns = MonotonicNowNs();
    if (ends_ns != 0 && MonotonicNowNs() - ends_ns > kGiveUpNs) _exit(kExitDevice);
  }
  thread.Join();
  watch.Forget();
  (*driver)->Stop();
  loop.Tell();
  return kExitOk;
}

int Run(int argc, char** argv) {
  CLI::App app{"Tandem's device process: has one device in hand, and is the last guard before its "
               "motors. 'tandem peer --device' starts it."};
  app.name("tandem-device");
  app.set_version_flag("--version", TANDEM_VERSION);
  DeviceArguments arguments;
  app.add_option("--driver", arguments.driver, "driver, as NAME[:OPTIONS]");
  app.add_option("--memory", arguments.memory, "file descriptor of the shared memory")
      ->check(WholeNumberFrom(0, 1'000'000));
  app.add_option("--most-force", arguments.users.force, "N, the user's setting")
      ->check(NumberAbove(0, kMostForAHand.force))
      ->capture_default_str();
  app.add_option("--most-moment", arguments.users.moment, "N m, the user's setting")
      ->check(NumberAbove(0, kMostForAHand.moment))
      ->capture_default_str();
  app.add_flag("--passivity-control", arguments.passivity_control,
               "damp a port that gives out more energy than it took");
  app.add_option("--core", arguments.core, "processor core that the loop keeps to")
      ->check(WholeNumberFrom(0, 1023));
  app.add_flag("--drivers", arguments.list, "list the drivers");
  if (const std::optional<int> ended = ParseOrExplain(app, argc, argv)) return *ended;
  if (arguments.list) {
    for (const DriverName& driver : Drivers()) std::printf("%-16s %s\n", driver.name, driver.what);
    return kExitOk;
  }
  if (arguments.driver.empty() || arguments.memory < 0) {
    std::fprintf(stderr, "tandem-device: --driver and --memory are wanted: 'tandem peer --device' "
                         "starts it; see tandem-device --help\n");
    return kExitUsage;
  }
  return Serve(arguments);
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  return tandem::Run(argc, argv);
}
