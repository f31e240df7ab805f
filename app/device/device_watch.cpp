#include "app/device/device_watch.h"

#include <algorithm>
#include <csignal>
#include <ctime>

#include <unistd.h>

#include "app/common/exit_codes.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/realtime_setup.h"

namespace tandem {
namespace {

constexpr std::array kFatal{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS, SIGTRAP};
constexpr std::array kIgnored{SIGINT, SIGQUIT, SIGTSTP, SIGTTIN, SIGTTOU, SIGPIPE};
// signals that end no process, or cannot be caught
constexpr std::array kLeftAlone{SIGKILL, SIGSTOP, SIGCONT, SIGCHLD, SIGURG, SIGWINCH};

// state that signal handlers use
std::atomic<bool> ending_now{false};
std::atomic<bool> opening{true};
std::atomic<bool> cutting{false};
std::atomic<bool> in_tick{false};
std::atomic<pid_t> loop_thread{0};
std::atomic<std::int64_t> ticked_ns{0};
std::atomic<Device*> motor{nullptr};
std::atomic<bool> at_motor{false};  // true: the watch may be using `motor`

using SignalStack = std::array<char, 65536>;
SignalStack main_stack, watch_stack, loop_stack;  // signal stacks, since a thread may have run out
                                                  // of its own

void Use(SignalStack& stack) noexcept {
  stack_t alternate{};
  alternate.ss_sp = stack.data();
  alternate.ss_size = stack.size();
  sigaltstack(&alternate, nullptr);
}

void End(int) {
  ending_now.store(true);
  // a driver that hangs while it opens would never return, and no loop runs yet that could end
  if (opening.load()) _exit(kExitOk);
}

// the last code of the process: sets zero force, then lets the signal kill the process
void CutForce(int signal) {
  cutting.store(true);
  if (Device* driver = motor.load()) {
    driver->Stop();
    if (gettid() != loop_thread.load()) {
      // the loop may be about to write
      for (int i = 0; i < 20 && in_tick.load(); ++i) {
        const timespec wait{.tv_sec = 0, .tv_nsec = 250'000};
        nanosleep(&wait, nullptr);
      }
      driver->Stop();
    }
  }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

bool EndsUs(int signal) {
  const auto among = [signal](const auto& some) {
    return std::find(some.begin(), some.end(), signal) != some.end();
  };
  // the C library reserves the first real-time signals
  const bool taken = signal > 31 && signal < SIGRTMIN;
  return !among(kFatal) && !among(kIgnored) && !among(kLeftAlone) && !taken;
}

/// Returns the signals that end the process in an orderly way.
sigset_t Ends() noexcept {
  sigset_t ends;
  sigemptyset(&ends);
  for (int signal = 1; signal <= SIGRTMAX; ++signal) {
    if (EndsUs(signal)) sigaddset(&ends, signal);
  }
  return ends;
}

void HearSignals() noexcept {
  const sigset_t ends = Ends();
  pthread_sigmask(SIG_UNBLOCK, &ends, nullptr);
}

void HandleSignals() {
  setsid();  // the controller answers signals of a terminal
  for (const int signal : kIgnored) std::signal(signal, SIG_IGN);
  for (int signal = 1; signal <= SIGRTMAX; ++signal) {
    if (EndsUs(signal)) std::signal(signal, End);
  }
  Use(main_stack);
  struct sigaction crash {};
  crash.sa_handler = CutForce;
  crash.sa_flags = SA_ONSTACK | SA_RESETHAND;
  for (const int signal : kFatal) sigaction(signal, &crash, nullptr);
  // blocked in this thread, and so in a driver's own threads
  const sigset_t ends = Ends();
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);
}

}  // namespace

DeviceWatch::DeviceWatch(pid_t controller, int priority) {
  HandleSignals();
  thread_ = std::thread([this, controller, priority] { Look(controller, priority); });
}

DeviceWatch::~DeviceWatch() {
  over_.store(true);
  thread_.join();
}

void DeviceWatch::Look(pid_t controller, int priority) noexcept {
  Use(watch_stack);
  static_cast<void>(EnterRealtime(priority));
  HearSignals();
  while (!over_.load()) {
    if (getppid() != controller) End(0);
    at_motor.store(true);
    if (Device* driver = motor.load()) {
      // a loop that stands still has left its last force at the motor
      if (MonotonicNowNs() - ticked_ns.load() > kStandsNs) {
        driver->Stop();
        if (ending_now.load()) _exit(kExitDevice);
      }
    }
    at_motor.store(false);
    MachineClock().SleepUntil(MonotonicNowNs() + kLookNs);
  }
}

void DeviceWatch::Guard(Device& driver) noexcept {
  ticked_ns.store(MonotonicNowNs());
  motor.store(&driver);
  opening.store(false);
}

void DeviceWatch::Forget() noexcept {
  motor.store(nullptr);
  // after this the driver may be destroyed
  const std::int64_t until_ns = MonotonicNowNs() + kForgetNs;
  while (at_motor.load()) {
    if (MonotonicNowNs() > until_ns) _exit(kExitDevice);  // hangs in the driver
    MachineClock().SleepUntil(MonotonicNowNs() + kLookNs / 10);
  }
}

void DeviceWatch::EnterLoop() noexcept {
  Use(loop_stack);
  loop_thread.store(gettid());
  HearSignals();
}

bool DeviceWatch::BeginTick() noexcept {
  in_tick.store(true);
  if (!cutting.load()) return true;
  in_tick.store(false);
  return false;
}

void DeviceWatch::EndTick() noexcept {
  ticked_ns.store(MonotonicNowNs());
  in_tick.store(false);
}

bool DeviceWatch::ending() const noexcept {
  return ending_now.load(std::memory_order_relaxed);
}

}  // namespace tandem
