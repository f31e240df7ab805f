#include "app/doctor/doctor_realtime.h"

#include <cstdio>
#include <fstream>

#include <sched.h>

#include "engine/realtime/periodic_thread.h"

namespace tandem {
namespace {

constexpr std::int64_t kTimerFrames = 500;   // frames of a millisecond
constexpr double kLateEnoughToFeelUs = 500;  // half a frame

/// Returns the first line of a file of the kernel; empty: there is no such file.
std::string FirstLine(const char* file) {
  std::string line;
  std::ifstream stream(file);
  std::getline(stream, line);
  return line;
}

void CheckRights(const RealtimeStatus& realtime, Findings& findings) {
  findings.Add(realtime.fifo ? Finding::kGood : Finding::kWarning, "priority",
               realtime.fifo ? "SCHED_FIFO: other programs wait for the frames of a hand"
                             : "SCHED_OTHER: a frame waits for other programs, and a hand feels it",
               realtime.fifo ? "" : realtime.warning);
  findings.Add(realtime.memory_locked ? Finding::kGood : Finding::kWarning, "locked memory",
               realtime.memory_locked
                   ? "all memory is locked: no frame waits for the disk"
                   : "no memory is locked: a frame may wait milliseconds for the disk",
               realtime.memory_locked || !realtime.fifo ? ""  // the advice on priority grants both
                                                        : realtime.warning);
  const std::string share = FirstLine("/proc/sys/kernel/sched_rt_runtime_us");
  if (!share.empty() && share != "-1" && realtime.fifo) {
    findings.Add(Finding::kGood, "real-time share",
                 share + " of " + FirstLine("/proc/sys/kernel/sched_rt_period_us") +
                     " us for SCHED_FIFO: enough, because a frame takes up to 800 of 1000 us");
  }
}

void CheckCores(Findings& findings) {
  cpu_set_t ours;
  CPU_ZERO(&ours);
  sched_getaffinity(0, sizeof ours, &ours);
  const int count = CPU_COUNT(&ours);
  findings.Add(count >= 2 ? Finding::kGood : Finding::kWarning, "cores",
               std::to_string(count) + " for this program",
               count >= 2 ? "" : "a device, its frames and the network need two cores");
  const std::string isolated = FirstLine("/sys/devices/system/cpu/isolated");
  findings.Add(Finding::kGood, "core of its own",
               isolated.empty() ? "none is set aside" : "set aside: " + isolated,
               isolated.empty()
                   ? "if frames are late: boot with isolcpus=N nohz_full=N, then give --core N"
                   : "tandem peer --core N runs its frames on one of them; --device-core N uses "
                     "another for the device");
  const std::string governor = FirstLine("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  if (governor.empty() || governor == "performance") return;
  findings.Add(Finding::kWarning, "clock", "governor '" + governor + "' lets idle cores slow down",
               "as root: cpupower frequency-set -g performance");
}

}  // namespace

void CheckRealtime(Findings& findings) {
  PeriodicThread thread({}, [](std::int64_t frame, std::int64_t) {
    return frame + 1 < kTimerFrames;
  });
  thread.Join();
  const RealtimeStatus& realtime = thread.realtime();
  CheckRights(realtime, findings);
  const double late_us = static_cast<double>(thread.stats().lateness().Quantile(0.99)) * 1e-3;
  const auto missed = static_cast<unsigned long long>(thread.stats().missed());
  std::array<char, 96> found{};
  std::snprintf(found.data(), found.size(), "99 %% of wakings within %.0f us, %llu of %lld missed",
                late_us, missed, static_cast<long long>(kTimerFrames));
  findings.Add(late_us > kLateEnoughToFeelUs ? Finding::kWarning : Finding::kGood, "timer",
               found.data(),
               late_us > kLateEnoughToFeelUs ? "end other programs, or give this one real-time "
                                               "rights; a virtual machine may not get better"
                                             : "");
  CheckCores(findings);
}

}  // namespace tandem
