// Tests the device process with a driver that is unwell, and by signals. The motor's writes are
// judged one by one.
#include "app/process/device_process.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <new>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/device/drivers/fake/fake_record.h"
#include "app/process/child_processes.h"
#include "engine/base/units.h"
#include "engine/haptics/process_device.h"
#include "engine/safety/motor_guard.h"
#include "tests/app/device/motor_writes.h"
#include "tests/app/device/own_controller.h"

namespace tandem {
namespace {

using testing::EmptyLoop;
using testing::kSlew;
using testing::Motor;
using testing::OwnController;
using testing::RunningController;
using testing::RunWithForce;
using testing::Sleep;

TEST(DeviceProcess, DriverClaimsCannotRaiseTheSafetyLimit) {
  const auto own = RunWithForce(
      29, 1500, ",peak_N=1000,peak_Nm=50,continuous_N=1000,continuous_Nm=50", 500, {30, 1});
  EXPECT_EQ(own->process->limits().force, 30);
  EXPECT_LE(own->All().most, 30 + 1e-9);
  EXPECT_LE(own->All().step, 5 + 1e-9);
}

TEST(DeviceProcess, InvalidPoseDriverFaultAndStopButtonEndTheForce) {
  const auto run = [](const std::string& options) {
    const auto own = RunWithForce(1.0, 1400, options);
    EXPECT_EQ(own->motor.force(), 0) << options;
    EXPECT_LE(own->All().step, kSlew + 1e-9) << options;
    return own->state();
  };
  EXPECT_EQ(run(",nan_at=800"), SafetyState::kFault);
  EXPECT_EQ(run(",fail_at=800"), SafetyState::kFault);
  EXPECT_EQ(run(",stop_at=800"), SafetyState::kStopped);
}

TEST(DeviceProcess, LeapingHandleGetsNoForce) {
  const auto own = RunWithForce(2.4, 1500, ",jump_at=1100");
  const std::vector<FakeRecord::Write> writes = own->motor.WritesSince(0);
  const auto whole = std::find_if(writes.begin(), writes.end(), [](const auto& write) {
    return Motor::ForceOf(write) > 2.4;
  });
  ASSERT_GT(writes.end() - whole, 300);
  // no force from five ticks after the leap until the sixteen ticks are over in which the leap
  // counts as speed
  const auto none = std::count_if(whole, whole + 300, [](const auto& write) {
    return Motor::ForceOf(write) == 0;
  });
  EXPECT_GE(none, 5);
  EXPECT_GE(own->process->Newest()->counts.zeroed, 1U);
  EXPECT_LE(own->All().step, kSlew + 1e-9);
}

// The driver's own read takes 30 ms. For as long the motor has an old force, and then none until a
// ramp-in.
TEST(DeviceProcess, HangingDriverIsAnOverrun) {
  const auto own = RunWithForce(1.9, 850, ",hang_at=800,hang_ms=30");
  EXPECT_EQ(own->motor.force(), 0);
  EXPECT_GE(own->process->Newest()->counts.zeroed, 1U);
}

TEST(DeviceProcess, CrashLeavesNoForce) {
  const auto own = RunWithForce(2.0, 1300, ",crash_at=1000");
  EXPECT_EQ(own->motor.force(), 0);
  EXPECT_THAT(own->process->News(), ::testing::HasSubstr("the device process ended"));
  EXPECT_EQ(own->process->News(), "");  // said once
}

TEST(DeviceProcess, SignalsLeaveNoForce) {
  for (const int signal : {SIGTERM, SIGHUP,  SIGUSR1, SIGUSR2, SIGALRM,   SIGVTALRM, SIGPROF,
                           SIGIO,   SIGXCPU, SIGXFSZ, SIGPWR,  SIGSTKFLT, SIGRTMIN,  SIGRTMAX,
                           SIGSYS,  SIGTRAP, SIGSEGV, SIGBUS,  SIGFPE,    SIGILL,    SIGABRT}) {
    RunningController own("");
    ASSERT_TRUE(own.motor.WaitForForce(0.5));
    kill(own.process->pid(), signal);
    EXPECT_TRUE(own.WaitForEnd()) << strsignal(signal);
    EXPECT_EQ(own.motor.force(), 0) << strsignal(signal);
  }
}

TEST(DeviceProcess, IgnoresTerminalSignals) {
  RunningController own("");
  ASSERT_TRUE(own.motor.WaitForForce(0.5));
  EXPECT_EQ(getsid(own.process->pid()), own.process->pid());  // a session of its own
  for (const int signal : {SIGINT, SIGQUIT, SIGTSTP, SIGTTIN, SIGTTOU, SIGPIPE}) {
    kill(own.process->pid(), signal);
    Sleep(0.05);
    const std::uint64_t seen = own.motor.count();
    // a machine that stands still for 20 ms takes the force away for a moment
    EXPECT_TRUE(own.motor.WaitForForce(0.4, 5)) << strsignal(signal);
    for (int i = 0; i < 5000 && own.motor.count() <= seen + 10; ++i) Sleep(1e-3);
    EXPECT_GT(own.motor.count(), seen + 10) << strsignal(signal);
  }
}

// The loop's thread runs out of its stack: the handler needs another one to run on.
TEST(DeviceProcess, StackOverflowInTheDriverLeavesNoForce) {
  RunningController own(",recurse_at=1500");
  ASSERT_TRUE(own.motor.WaitForForce(1.0));
  EXPECT_TRUE(own.WaitForEnd());
  EXPECT_EQ(own.motor.force(), 0);
}

TEST(DeviceProcess, HungDriverLeavesNoForceAndCanBeEnded) {
  RunningController own(",hang_at=1500,hang_ms=1e6");
  ASSERT_TRUE(own.motor.WaitForForce(1.0));
  EmptyLoop empty;
  own.motor.WaitForNoForce();
  const double late_ms = empty.WorstMs();
  EXPECT_EQ(own.motor.force(), 0);
  const std::vector<FakeRecord::Write> writes = own.motor.WritesSince(0);
  const auto zero = std::find_if(writes.rbegin(), writes.rend(), [](const auto& write) {
    return Motor::ForceOf(write) > 0;
  });
  ASSERT_NE(zero, writes.rbegin());
  const double kept_ms = 1e-6 * static_cast<double>(std::prev(zero)->ns - zero->ns);
  RecordProperty("kept_ms", std::to_string(kept_ms));
  // 20 ms, and the check after that
  EXPECT_GE(kept_ms, 15);
  EXPECT_LE(kept_ms, 60 + late_ms);
  kill(own.process->pid(), SIGTERM);
  EXPECT_TRUE(own.WaitForEnd());
  EXPECT_EQ(own.motor.force(), 0);
}

TEST(DeviceProcess, DriverHangingInOpenCanBeEnded) {
  Result<SharedMemory> shared = SharedMemory::Create("tandem-device", sizeof(DeviceMemory));
  ASSERT_TRUE(shared);
  auto* memory = new (shared->data()) DeviceMemory;
  memory->version = DeviceMemory::kVersion;
  memory->home = AsNumbers(Pose{});
  Result<ChildProcess> process =
      ChildProcess::Start({TANDEM_DEVICE, "--driver", "fake:open_hang_ms=1e6", "--memory",
                           std::to_string(shared->descriptor())},
                          shared->descriptor());
  ASSERT_TRUE(process);
  Sleep(0.5);
  EXPECT_FALSE(process->Poll());
  process->Signal(SIGTERM);
  EXPECT_TRUE(process->Wait(std::chrono::seconds(20)));
}

// The vendor's thread goes on asking while the loop stands still in a read.
TEST(DeviceProcess, StalledLoopGivesAVendorThreadNoForce) {
  int judged = 0;
  const std::array<const char*, 3> rates{"500", "1000", "3000"};
  for (std::size_t round = 0; round < 3 || (judged == 0 && round < 12); ++round) {
    const char* rate = rates[round % 3];
    EmptyLoop empty;
    // after the ramp of a second, with time for a machine that is late
    const int hang_at = static_cast<int>(2.5 * std::min(1000.0, std::stod(rate)));
    RunningController own(",vendor=1,peak_N=3,hang_ms=1500,hang_at=" + std::to_string(hang_at) +
                          ",rate_hz=" + rate);
    ASSERT_TRUE(own.motor.WaitForForce(0.2)) << rate;
    ASSERT_TRUE(own.motor.WaitForForce(1.0)) << rate;
    own.motor.WaitForNoForce();
    EXPECT_EQ(own.motor.force(), 0) << rate;
    const std::vector<FakeRecord::Write> writes = own.motor.WritesSince(0);
    // The force was not cut when it was 20 ms old. It had fallen by then, from 5 ms of age on, by
    // half a newton a millisecond. Between two writes it may fall by no more, however late this
    // machine makes the second.
    const auto last = std::find_if(writes.rbegin(), writes.rend(), [](const auto& write) {
      return Motor::ForceOf(write) > 0;
    });
    ASSERT_NE(last, writes.rend());
    ASSERT_NE(last, writes.rbegin());
    const double gap_ms = 1e-6 * static_cast<double>(std::prev(last)->ns - last->ns);
    if (gap_ms * kMs < MotorGuard::kMostGapNs) {
      EXPECT_LT(Motor::ForceOf(*last), 3.0 / MotorGuard::kSlewTicks * gap_ms + 0.25) << rate;
      ++judged;
    }
    const DeviceTimes times = own.process->times();
    const double late_ms = empty.WorstMs();
    const std::string key = std::string("age_us_at_") + rate + "_Hz";
    RecordProperty(key + "_mean", static_cast<int>(times.asked_mean_ns / 1000));
    RecordProperty(key + "_most", static_cast<int>(times.asked_max_ns / 1000));
    EXPECT_GT(times.requested, 50U) << rate;
    // the phase of the two loops adds from nothing to a period
    EXPECT_LE(1e-6 * static_cast<double>(times.asked_mean_ns),
              1e3 / std::stod(rate) + 0.1 * late_ms)
        << rate << " Hz; an empty loop was late by " << late_ms << " ms";
  }
  EXPECT_GE(judged, 1);
}

TEST(DeviceProcess, ReportsSchedulingAndTickRate) {
  const auto process = DeviceProcess::Start({.driver = "fake:rate_hz=500", .core = 1023});
  ASSERT_TRUE(process);
  EXPECT_THAT((*process)->scheduler(), ::testing::StartsWith("SCHED_"));
  EXPECT_THAT((*process)->warning(), ::testing::HasSubstr("core 1023 cannot be had"));
  EXPECT_EQ((*process)->period_ns(), 2 * kMs);
}

TEST(DeviceProcess, PassivityControlIsOptionalAndReported) {
  for (const bool control : {false, true}) {
    const auto process = DeviceProcess::Start({.driver = "fake:", .passivity_control = control});
    ASSERT_TRUE(process);
    for (int i = 0; i < 4000 && !(*process)->Newest(); ++i) Sleep(5e-3);
    ASSERT_TRUE((*process)->Newest()) << "the device has no tick";
    EXPECT_EQ((*process)->Newest()->passivity.control, control);
  }
}

TEST(DeviceProcess, EndsCleanlyOnRequest) {
  RunningController own("");
  // a loaded machine takes the force away again and again: some force is enough
  ASSERT_TRUE(own.motor.WaitForForce(0.5, 60));
  own.process->End();
  EXPECT_EQ(own.motor.force(), 0);
  EXPECT_LE(own.All().step, kSlew + 1e-9);
}

TEST(DeviceProcess, ReportsWhyTheDeviceIsMissing) {
  const auto none = DeviceProcess::Start({.driver = "omega:7"});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().what, ::testing::HasSubstr("there is no driver 'omega'"));
  const auto wrong = DeviceProcess::Start({.driver = "fake:peak_N=lots"});
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().what, ::testing::HasSubstr("expected a number, got 'lots'"));
}

TEST(DeviceProcess, ProgramStartedByHandExitsWithItsErrorCodes) {
  const std::string run = std::string(TANDEM_DEVICE) +
                          " --driver none: --memory 0 </dev/null "
                          "2>/dev/null";
  EXPECT_EQ(WEXITSTATUS(std::system(run.c_str())), 6);
  const std::string bare = std::string(TANDEM_DEVICE) + " 2>/dev/null";
  EXPECT_EQ(WEXITSTATUS(std::system(bare.c_str())), 2);
}

// a session's sockets, keys and files are none of a vendor's library
TEST(DeviceProcess, InheritsNoDescriptorOfItsController) {
  const int ours = open("/dev/null", O_RDONLY);  // without O_CLOEXEC, as DDS opens its sockets
  ASSERT_GE(ours, 0);
  const OwnController own("");
  std::size_t seen = 0;
  const std::string process = "/proc/" + std::to_string(own.process->pid()) + "/fd";
  for (const auto& entry : std::filesystem::directory_iterator(process)) {
    const std::string number = entry.path().filename();
    const std::string target = std::filesystem::read_symlink(entry.path());
    ++seen;
    if (std::stoi(number) <= STDERR_FILENO) continue;
    EXPECT_THAT(target,
                ::testing::AnyOf(::testing::HasSubstr("memfd:"), ::testing::HasSubstr("motor"),
                                 ::testing::HasSubstr("anon_inode:")))
        << number;
  }
  EXPECT_GE(seen, 4U);
  close(ours);
}

TEST(DeviceProcess, StoppedProcessIsReportedAndEndsInOrder) {
  RunningController own("");
  ASSERT_TRUE(own.motor.WaitForForce(0.5));
  own.process->News();
  kill(own.process->pid(), SIGSTOP);
  std::string line;
  for (int i = 0; i < 200 && line.find("silent") == std::string::npos; ++i) {
    Sleep(0.01);
    line = own.process->News();
  }
  EXPECT_THAT(line, ::testing::HasSubstr("has been silent for 50 ms"));
  kill(own.process->pid(), SIGCONT);
  for (int i = 0; i < 200 && line.find("again") == std::string::npos; ++i) {
    Sleep(0.01);
    line = own.process->News();
  }
  EXPECT_THAT(line, ::testing::HasSubstr("answers again"));
  kill(own.process->pid(), SIGSTOP);
  Sleep(0.1);
  own.process->End();
  EXPECT_TRUE(own.WaitForEnd(1));
  EXPECT_EQ(own.motor.force(), 0);
}

}  // namespace
}  // namespace tandem
