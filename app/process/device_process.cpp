#include "app/process/device_process.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <new>
#include <utility>

#include "app/common/program_folders.h"
#include "app/common/stop_signal.h"
#include "engine/haptics/process_device.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr std::int64_t kOpeningNs = 20'000'000'000;  // a driver may look for its device for long
constexpr std::int64_t kPollNs = 2'000'000;
constexpr std::chrono::milliseconds kEnding{3000};
constexpr std::chrono::milliseconds kHastyEnding{400};  // while a signal ends this program
constexpr std::chrono::milliseconds kEndStep{20};
constexpr std::int64_t kSilentNs = 50'000'000;  // time without a tick that a user is told of

std::string Exactly(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", number);
  return text;
}

const char* Told(SafetyState state) {
  switch (state) {
    case SafetyState::kTooFast:
      return "device: no force, because the handle moved too fast; force returns when it is slow";
    case SafetyState::kExpired:
      return "device: no force, because the simulation was late; force returns by itself";
    case SafetyState::kOverrun:
      return "device: no force, because its own loop was late; force returns by itself";
    case SafetyState::kSuspended:
      return "device: no force, because this machine slept; force returns by itself";
    case SafetyState::kFault:
      return "device: no force after a fault; type 'resume' to get it back";
    case SafetyState::kStopped:
      return "device: emergency stop; type 'resume' to end it";
    default:
      return "";
  }
}

}  // namespace

DeviceProcess::DeviceProcess(SharedMemory shared, ChildProcess process)
    : shared_(std::move(shared)),
      memory_(static_cast<DeviceMemory*>(shared_.data())),
      process_(std::move(process)) {}

Result<std::unique_ptr<DeviceProcess>> DeviceProcess::Start(const Options& options) {
  Result<SharedMemory> shared = SharedMemory::Create("tandem-device", sizeof(DeviceMemory));
  if (!shared) return shared.error();
  auto* memory = new (shared->data()) DeviceMemory;
  memory->version = DeviceMemory::kVersion;
  memory->home = AsNumbers(options.home_W);
  std::vector<std::string> words{ProgramFolder() / "tandem-device",
                                 "--driver",
                                 options.driver,
                                 "--memory",
                                 std::to_string(shared->descriptor()),
                                 "--most-force",
                                 Exactly(options.users.force),
                                 "--most-moment",
                                 Exactly(options.users.moment)};
  if (options.core >= 0) {
    words.insert(words.end(), {"--core", std::to_string(options.core)});
  }
  if (options.passivity_control) words.emplace_back("--passivity-control");
  Result<ChildProcess> started = ChildProcess::Start(words, shared->descriptor());
  if (!started) return started.error();
  std::unique_ptr<DeviceProcess> process(
      new DeviceProcess(*std::move(shared), *std::move(started)));
  const std::int64_t until_ns = MonotonicNowNs() + kOpeningNs;
  while (true) {
    const std::uint32_t ready = memory->ready.load(std::memory_order_acquire);
    if (ready == DeviceMemory::kReady) return process;
    if (ready == DeviceMemory::kFailed)
      return Error{"--device: " + std::string(memory->fault.data())};
    if (const std::optional<int> code = process->process_.Poll()) {
      return Error{"tandem-device ended with exit code " + std::to_string(*code)};
    }
    if (MonotonicNowNs() > until_ns) return Error{"the device did not open within 20 s"};
    MachineClock().SleepUntil(MonotonicNowNs() + kPollNs);
  }
}

std::unique_ptr<Device> DeviceProcess::MakeDevice() {
  return std::make_unique<ProcessDevice>(*memory_);
}

std::optional<DeviceTick> DeviceProcess::Newest() const noexcept {
  DeviceTick tick;
  if (!memory_->tick.Read(tick)) return std::nullopt;
  return tick;
}

DeviceTimes DeviceProcess::times() const noexcept {
  DeviceTimes times;
  memory_->times.Read(times);
  return times;
}

std::string DeviceProcess::News() {
  if (const std::optional<int> code = process_.Poll()) {
    if (std::exchange(end_told_, true)) return {};
    return "the device process ended (exit code " + std::to_string(*code) +
           "): your hand stays where it was";
  }
  if (const std::string line = Silence(MonotonicNowNs()); !line.empty()) return line;
  std::array<char, 320> trouble{};
  if (memory_->trouble.Read(trouble) && trouble_told_ != trouble.data()) {
    trouble_told_ = trouble.data();
    if (!trouble_told_.empty()) return "device " + trouble_told_;
    const bool has_motors = AsCapabilities(memory_->capabilities).freedoms_out > 0;
    return has_motors ? "device is back: type 'resume' to get force again" : "device is back";
  }
  const std::optional<DeviceTick> tick = Newest();
  if (!tick) return {};
  const auto state = static_cast<SafetyState>(tick->state);
  return std::exchange(reported_, state) == state ? "" : Told(state);
}

std::string DeviceProcess::Silence(std::int64_t now_ns) {
  const std::optional<DeviceTick> tick = Newest();
  if (!tick) return {};
  const std::int64_t patience_ns = std::max(kSilentNs, 5 * memory_->period_ns);
  const bool silent = now_ns - tick->input_ns > patience_ns;
  if (std::exchange(silent_, silent) == silent) return {};
  if (!silent) return "the device process answers again";
  return "the device process has been silent for " + std::to_string(patience_ns / 1'000'000) +
         " ms: your hand stays where it was, and the device may keep its last force: switch it off "
         "if it pulls";
}

void DeviceProcess::End() {
  process_.Signal(SIGTERM);
  process_.Signal(SIGCONT);  // a stopped process would not hear the other signal
  const bool hasty = StopRequestedWithin(std::chrono::nanoseconds(0));
  const std::chrono::milliseconds patience = hasty ? kHastyEnding : kEnding;
  for (auto waited = kEndStep; waited <= patience && !process_.Wait(kEndStep); waited += kEndStep) {
    SayStillEnding();
  }
  if (!process_.Poll()) process_.Signal(SIGKILL);
  end_told_ = true;
}

}  // namespace tandem
