// The process that has a device in hand. A controller (`tandem peer --device`) starts it and shares
// memory with it. Whatever happens to the controller, no force stays at the motor.
#include <array>
#include <atomic>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/device/device_watch.h"
#include "app/device/list_devices.h"
#include "app/device/open_driver.h"
#include "app/device/try_device.h"
#include "engine/haptics/device_loop.h"
#include "engine/realtime/periodic_thread.h"
#include "engine/realtime/shared_memory.h"

namespace tandem {
namespace {

constexpr int kPriority = 40;  // above all threads of the controller: the motor is served first
constexpr std::int64_t kSleptEnoughNs = 10'000'000;
constexpr std::int64_t kGiveUpNs = 1'000'000'000;  // for a driver that hangs even in Stop()

struct DeviceArguments {
  std::string driver;
  int memory = -1;
  DeviceLimits users = kUsersDefault;
  bool passivity_control = false;
  int core = -1;
  bool names = false;
  std::string list;    // driver to list devices of
  std::string tried;   // device to try
  double seconds = 5;  // length of the trial
  int to = 1;          // descriptor that gets the answer
};

int Answer(const DeviceArguments& arguments, const std::string& text) {
  return dprintf(arguments.to, "%s\n", text.c_str()) > 0 ? kExitOk : kExitFile;
}

int FailWith(DeviceMemory& memory, const std::string& why) {
  std::snprintf(memory.fault.data(), memory.fault.size(), "%s", why.c_str());
  memory.ready.store(DeviceMemory::kFailed, std::memory_order_release);
  return kExitDevice;
}

/// Tells the controller why the device is in trouble, and when the trouble is over.
class TroubleReporter {
 public:
  explicit TroubleReporter(DeviceMemory& memory) : memory_(&memory) {}
  void Look(const DriverDevice& device) {
    const std::string trouble = device.Trouble();
    if (trouble == reported_) return;
    reported_ = trouble;
    std::array<char, 320> text{};
    std::snprintf(text.data(), text.size(), "%s", trouble.c_str());
    memory_->trouble.Write(text);
  }

 private:
  DeviceMemory* memory_;
  std::string reported_;
};

int Serve(const DeviceArguments& arguments) {
  const pid_t controller = getppid();
  Result<SharedMemory> shared = SharedMemory::Attach(arguments.memory, sizeof(DeviceMemory));
  if (!shared) {
    SayAs("tandem-device", shared.error().what + "; 'tandem peer --device' starts it");
    return kExitDevice;
  }
  auto& memory = *static_cast<DeviceMemory*>(shared->data());
  if (memory.version != DeviceMemory::kVersion) {
    return FailWith(memory,
                    "tandem-device and the program that started it have different versions: "
                    "install both of one version");
  }
  DeviceWatch watch(controller, kPriority + 1);
  Result<std::unique_ptr<DriverDevice>> driver = OpenDriver(arguments.driver, AsPose(memory.home));
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
        // checked here too, since the watch may wait long on a busy machine
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
  TroubleReporter teller(memory);
  while (!ended.load()) {
    MachineClock().SleepUntil(MonotonicNowNs() + DeviceWatch::kLookNs);
    teller.Look(**driver);
    if (watch.ending() && ends_ns == 0) ends_ns = MonotonicNowNs();
    if (ends_ns != 0 && MonotonicNowNs() - ends_ns > kGiveUpNs) _exit(kExitDevice);
  }
  thread.Join();
  watch.Forget();
  (*driver)->Stop();
  loop.PublishTimes();
  return kExitOk;
}

int Run(int argc, char** argv) {
  CLI::App app{
      "Tandem's device process: it runs one device, and is the last guard before its motors. "
      "'tandem peer --device' starts it."};
  app.name("tandem-device");
  app.set_version_flag("--version", TANDEM_VERSION);
  DeviceArguments arguments;
  app.add_option("--driver", arguments.driver, "driver of the device, as NAME[:OPTIONS]");
  app.add_option("--memory", arguments.memory, "file descriptor of the shared memory")
      ->check(WholeNumberFrom(0, 1'000'000));
  app.add_option("--most-force", arguments.users.force, "force limit that the user set, N")
      ->check(NumberAbove(0, kMostForAHand.force))
      ->capture_default_str();
  app.add_option("--most-moment", arguments.users.moment, "moment limit that the user set, N m")
      ->check(NumberAbove(0, kMostForAHand.moment))
      ->capture_default_str();
  app.add_flag("--passivity-control", arguments.passivity_control,
               "passivity control: damp a device that gives out more energy than it took in");
  app.add_option("--core", arguments.core, "processor core of the loop")
      ->check(WholeNumberFrom(0, 1023));
  app.add_flag("--drivers", arguments.names, "print the drivers' names");
  app.add_option("--list", arguments.list,
                 "print the devices of a driver, and what is missing, as one JSON object");
  app.add_option(
      "--try", arguments.tried,
      "read the device NAME[:OPTIONS] for a while without force, and print one JSON object");
  app.add_option("--seconds", arguments.seconds, "duration of --try, s")
      ->check(NumberFrom(0, 3600))
      ->capture_default_str();
  app.add_option("--to", arguments.to, "file descriptor for what --drivers, --list and --try print")
      ->check(WholeNumberFrom(1, 1'000'000))
      ->capture_default_str();
  if (const std::optional<int> ended = ParseOrExplain(app, argc, argv)) return *ended;
  if (arguments.names) {
    std::string lines;
    for (const std::string& name : DriverNames()) lines += (lines.empty() ? "" : "\n") + name;
    return Answer(arguments, lines);
  }
  if (!arguments.list.empty()) return Answer(arguments, DevicesOf(arguments.list));
  if (!arguments.tried.empty()) {
    const Result<std::string> seen = TryDevice(arguments.tried, arguments.seconds);
    if (seen) return Answer(arguments, *seen);
    SayAs("tandem-device", seen.error().what);
    return kExitDevice;
  }
  if (arguments.driver.empty() || arguments.memory < 0) {
    SayAs("tandem-device",
          "give --driver and --memory; 'tandem peer --device' does that for you (tandem-device "
          "--help)");
    return kExitUsage;
  }
  return Serve(arguments);
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  return tandem::Run(argc, argv);
}
