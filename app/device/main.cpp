// The process that has a device in hand. A controller (`tandem peer --device`) starts it and shares
// memory with it; nothing that becomes of the controller leaves a force at the motor.
#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <unistd.h>

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
constexpr std::int64_t kLookNs = 5'000'000;  // between looks at signals

std::atomic<bool> ending{false};
Device* crash_driver = nullptr;

void End(int) {
  ending.store(true);
}

// no code of ours goes on from here: the motor gets zero, and then the process dies as it would have
void CutForce(int signal) {
  if (crash_driver != nullptr) crash_driver->Stop();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void HandleSignals() {
  for (const int signal : {SIGTERM, SIGHUP}) std::signal(signal, End);
  // what a terminal sends to all its programs is the controller's to answer
  for (const int signal : {SIGINT, SIGTSTP, SIGTTIN, SIGTTOU, SIGPIPE}) {
    std::signal(signal, SIG_IGN);
  }
  static std::array<char, 65536> stack;  // a thread may have run out of its own
  stack_t alternate{};
  alternate.ss_sp = stack.data();
  alternate.ss_size = stack.size();
  sigaltstack(&alternate, nullptr);
  struct sigaction crash {};
  crash.sa_handler = CutForce;
  crash.sa_flags = SA_ONSTACK | SA_RESETHAND;
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
    sigaction(signal, &crash, nullptr);
  }
}

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
  Result<std::unique_ptr<Device>> driver = OpenDriver(arguments.driver, AsPose(memory.home));
  if (!driver) return FailWith(memory, driver.error().what);
  crash_driver = driver->get();
  DeviceLoop loop(**driver, memory, MachineClock(),
                  {.users = arguments.users, .passivity_control = arguments.passivity_control});
  const std::int64_t origin_ns = MonotonicNowNs();
  memory.origin_ns = origin_ns;
  std::int64_t slept_ns = SleptNs();
  std::atomic<bool> at_rest{false};
  PeriodicThread thread(
      {.period_ns = DeviceLoop::kPeriodNs,
       .origin_ns = origin_ns,
       .priority = kPriority,
       .core = arguments.core,
       .name = "device"},
      [&](std::int64_t, std::int64_t now_ns) {
        const std::int64_t slept_now_ns = SleptNs();
        // here, for the main thread may wait for long on a busy machine
        if (getppid() != controller) ending.store(true, std::memory_order_relaxed);
        const bool ends = ending.load(std::memory_order_relaxed);
        loop.Tick({.deadline_ns = now_ns - (now_ns - origin_ns) % DeviceLoop::kPeriodNs,
                   .ending = ends,
                   .slept = slept_now_ns - slept_ns > kSleptEnoughNs});
        slept_ns = slept_now_ns;
        return !(ends && loop.at_rest());
      });
  // signals go to the loop's thread, which other programs do not hold up
  sigset_t ends;
  sigemptyset(&ends);
  sigaddset(&ends, SIGTERM);
  sigaddset(&ends, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
  memory.ready.store(DeviceMemory::kReady, std::memory_order_release);
  while (!ending.load()) {
    MachineClock().SleepUntil(MonotonicNowNs() + kLookNs);
  }
  thread.Join();
  (*driver)->Stop();
  loop.Tell();
  crash_driver = nullptr;
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
  HandleSignals();
  return Serve(arguments);
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  return tandem::Run(argc, argv);
}
