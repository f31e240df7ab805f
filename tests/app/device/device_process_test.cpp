// Tests the device process with a controller that dies or stands still. The motor's writes are
// judged one by one.
#include "app/cli/device_process.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/cli/child_processes.h"
#include "app/device/drivers/fake/fake_record.h"
#include "engine/haptics/process_device.h"
#include "engine/realtime/periodic_thread.h"
#include "engine/safety/motor_guard.h"

namespace tandem {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr double kClamp = kUsersDefault.force;
constexpr double kSlew = kClamp / MotorGuard::kSlewTicks;

/// Returns how often a controller is killed, and how often it is stopped.
int Rounds() {
  const char* asked = std::getenv("TANDEM_DEVICE_KILLS");
  return asked != nullptr ? std::atoi(asked) : 8;
}

void Sleep(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// Reads a motor's writes, as the driver `fake` keeps them in a file.
class Motor {
 public:
  explicit Motor(const std::filesystem::path& file) {
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    EXPECT_EQ(ftruncate(descriptor, sizeof(FakeRecord)), 0);
    void* data =
        mmap(nullptr, sizeof(FakeRecord), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    close(descriptor);
    EXPECT_NE(data, MAP_FAILED);
    record_ = static_cast<FakeRecord*>(data);
  }
  Motor(const Motor&) = delete;
  ~Motor() { munmap(record_, sizeof(FakeRecord)); }

  std::uint64_t count() const { return record_->count.load(std::memory_order_acquire); }
  std::vector<FakeRecord::Write> Since(std::uint64_t first) const {
    std::vector<FakeRecord::Write> writes;
    for (std::uint64_t i = first; i < count(); ++i) {
      writes.push_back(record_->writes[i % FakeRecord::kRoom]);
    }
    return writes;
  }
  static double ForceOf(const FakeRecord::Write& write) {
    return std::hypot(write.force_N[0], write.force_N[1], write.force_N[2]);
  }
  double force() const {
    const std::uint64_t written = count();
    return written == 0 ? 0 : ForceOf(record_->writes[(written - 1) % FakeRecord::kRoom]);
  }
  bool WaitForForce(double force_N, double seconds = 20) const {
    for (int i = 0; i < 1000 * seconds && force() < force_N; ++i) Sleep(1e-3);
    return force() >= force_N;
  }
  /// Waits until there is no force for half a second: a machine that is late may take it away for
  /// some 150 ms before that.
  void WaitForNoForce() const {
    int quiet_ms = 0;
    for (int i = 0; i < 10'000 && quiet_ms < 500; ++i) {
      Sleep(1e-3);
      quiet_ms = force() > 0 ? 0 : quiet_ms + 1;
    }
  }

 private:
  FakeRecord* record_ = nullptr;
};

/// Runs a loop that does nothing beside the test, and keeps how late this machine made it at the
/// worst. This lateness excuses a device's loop, whose own lateness does not.
class EmptyLoop {
 public:
  EmptyLoop()
      : thread_({.priority = 40}, [](std::int64_t, std::int64_t) {
          return true;
        }) {}
  double WorstMs() {
    thread_.Stop();
    thread_.Join();
    return 1e-6 * static_cast<double>(thread_.stats().lateness().max());
  }

 private:
  PeriodicThread thread_;
};

/// The fall of the force after the controller was gone.
struct Fall {
  double damping_ms = 0;  // time until the fall began
  double zero_ms = 0;     // time until there was no force
  double gap_ms = 0;      // longest time between two writes meanwhile
  double most = 0;        // N; largest force
  double step = 0;        // N; largest change between two writes of a loop in time
};

Fall FallAfter(const std::vector<FakeRecord::Write>& writes, std::int64_t gone_ns) {
  Fall fall;
  double before = 0;
  double held = -1;
  bool fallen = false;
  std::int64_t before_ns = 0;
  for (const FakeRecord::Write& write : writes) {
    const double force = Motor::ForceOf(write);
    fall.most = std::max(fall.most, force);
    if (before_ns != 0 && write.ns - before_ns < MotorGuard::kMostGapNs) {
      fall.step = std::max(fall.step, std::abs(force - before));
    }
    if (write.ns > gone_ns) {
      const double after_ms = 1e-6 * static_cast<double>(write.ns - gone_ns);
      if (before_ns != 0 && fall.zero_ms == 0) {
        fall.gap_ms = std::max(fall.gap_ms, 1e-6 * static_cast<double>(write.ns - before_ns));
      }
      if (held < 0) held = before;
      held = fallen ? held : std::max(held, force);
      if (!fallen && force < held - 1e-9) {
        fallen = true;
        fall.damping_ms = after_ms;
      }
      if (force == 0 && fall.zero_ms == 0) fall.zero_ms = after_ms;
      if (force > 0) fall.zero_ms = 0;
    }
    before = force;
    before_ns = write.ns;
  }
  return fall;
}

/// The worst figures of many falls.
struct Worst {
  double damping_ms = 0, zero_ms = 0, gap_ms = 0, empty_ms = 0;
  void Add(const Fall& fall, double empty) {
    damping_ms = std::max(damping_ms, fall.damping_ms);
    zero_ms = std::max(zero_ms, fall.zero_ms);
    gap_ms = std::max(gap_ms, fall.gap_ms);
    empty_ms = std::max(empty_ms, empty);
  }
};

/// Expects that force began to end within 5 ms and had ended within 20, a tick later at the most.
/// The lateness of an empty loop in the same round comes on top: the process notices at a tick that
/// an order is old.
void ExpectInTime(const Fall& fall, double empty_ms) {
  EXPECT_GT(fall.damping_ms, 0) << "the force never fell";
  EXPECT_LE(fall.damping_ms, 5 + 1 + empty_ms);
  EXPECT_GT(fall.zero_ms, 0) << "the force never ended";
  EXPECT_LE(fall.zero_ms, 20 + 1 + empty_ms);
  EXPECT_LE(fall.most, kClamp + 1e-9);
  EXPECT_LE(fall.step, kSlew + 1e-9);
}

void Tell(const char* what, int rounds, const Worst& worst) {
  std::printf(
      "%s, %d times: force falls after %.2f ms at the most, is gone after %.2f ms; longest "
      "gap of the device's loop %.2f ms; an empty loop's worst lateness %.2f ms\n",
      what, rounds, worst.damping_ms, worst.zero_ms, worst.gap_ms, worst.empty_ms);
  ::testing::Test::RecordProperty("damping_ms", std::to_string(worst.damping_ms));
  ::testing::Test::RecordProperty("zero_ms", std::to_string(worst.zero_ms));
}

TEST(DeviceProcess, TheForceOfAKilledControllerIsGoneInTime) {
  const TemporaryFolder folder;
  std::mt19937 random(1);
  Worst worst;
  for (int round = 0; round < Rounds(); ++round) {
    const std::filesystem::path file = folder.path() / ("motor" + std::to_string(round));
    const Motor motor(file);
    Result<ChildProcess> puppet =
        ChildProcess::Start({TANDEM_PUPPET, "fake:record=" + file.string()});
    ASSERT_TRUE(puppet);
    ASSERT_TRUE(motor.WaitForForce(1.0));
    Sleep(1e-6 * static_cast<double>(random() % 20'000));
    EmptyLoop empty;
    const std::uint64_t seen = motor.count();
    const std::int64_t gone_ns = MonotonicNowNs();
    puppet->Signal(SIGKILL);
    Sleep(0.06);
    const Fall fall = FallAfter(motor.Since(seen - 20), gone_ns);
    const double empty_ms = empty.WorstMs();
    ExpectInTime(fall, empty_ms);
    worst.Add(fall, empty_ms);
    // the device process ends by itself: nothing is left behind
    const std::uint64_t written = motor.count();
    Sleep(0.02);
    EXPECT_LE(motor.count(), written + 1);
    std::filesystem::remove(file);
  }
  Tell("killed", Rounds(), worst);
}

// The test is the parent of the device process and lives on, so nobody tells that process that its
// controller is gone. The age of its orders alone ends the force.
TEST(DeviceProcess, TheForceOfAControllerWhoseEndNobodyTellsIsGoneInTime) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "motor";
  std::mt19937 random(3);
  Worst worst;
  int judged = 0;
  const Motor motor(file);
  const auto process = DeviceProcess::Start({.driver = "fake:record=" + file.string()});
  ASSERT_TRUE(process);
  const std::string memory = std::to_string((*process)->descriptor());
  Result<SharedMemory> shared =
      SharedMemory::Attach(dup((*process)->descriptor()), sizeof(DeviceMemory));
  ASSERT_TRUE(shared);
  const auto& orders = static_cast<const DeviceMemory*>(shared->data())->order;
  for (int round = 0; round < Rounds(); ++round) {
    Result<ChildProcess> puppet =
        ChildProcess::Start({TANDEM_PUPPET, "--memory", memory}, (*process)->descriptor());
    ASSERT_TRUE(puppet);
    ASSERT_TRUE(motor.WaitForForce(1.0));
    Sleep(1e-6 * static_cast<double>(random() % 20'000));
    EmptyLoop empty;
    const std::uint64_t seen = motor.count();
    const std::int64_t gone_ns = MonotonicNowNs();
    puppet->Signal(SIGKILL);
    Sleep(0.06);
    const Fall fall = FallAfter(motor.Since(seen - 20), gone_ns);
    const double empty_ms = empty.WorstMs();
    ExpectInTime(fall, empty_ms);
    worst.Add(fall, empty_ms);
    // its own rule ended the force, which fell when the input of the last order was five
    // milliseconds old, however long before its end the controller gave that order. Another rule
    // may have been first where the machine stood still, or where the end came as an order was
    // written
    DeviceOrder last;
    if (empty_ms > 2 || !orders.Read(last)) continue;
    ++judged;
    EXPECT_GE(fall.damping_ms + 1e-6 * static_cast<double>(gone_ns - last.input_ns), 5);
    EXPECT_EQ((*process)->Newest()->state, static_cast<std::uint8_t>(SafetyState::kExpired));
  }
  EXPECT_GE(judged, Rounds() / 4);
  Tell("killed untold", Rounds(), worst);
}

TEST(DeviceProcess, TheForceOfAStoppedControllerIsGoneInTimeAndComesBack) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "motor";
  std::mt19937 random(2);
  Worst worst;
  const Motor motor(file);
  Result<ChildProcess> puppet =
      ChildProcess::Start({TANDEM_PUPPET, "fake:record=" + file.string()});
  ASSERT_TRUE(puppet);
  for (int round = 0; round < Rounds(); ++round) {
    ASSERT_TRUE(motor.WaitForForce(0.9));
    Sleep(1e-6 * static_cast<double>(random() % 20'000));
    EmptyLoop empty;
    const std::uint64_t seen = motor.count();
    const std::int64_t gone_ns = MonotonicNowNs();
    puppet->Signal(SIGSTOP);
    Sleep(0.05);
    const Fall fall = FallAfter(motor.Since(seen - 20), gone_ns);
    puppet->Signal(SIGCONT);
    const double empty_ms = empty.WorstMs();
    ExpectInTime(fall, empty_ms);
    worst.Add(fall, empty_ms);
    EXPECT_EQ(motor.force(), 0);
  }
  EXPECT_TRUE(motor.WaitForForce(2.4, 60));
  Tell("stopped", Rounds(), worst);
}

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
  Fall All() const { return FallAfter(motor.Since(0), MonotonicNowNs()); }
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
std::unique_ptr<OwnController> RunWithForce(double rise_N, int frames, const std::string& options,
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

TEST(DeviceProcess, WhateverADriverClaimsNoHandGetsMoreThanItMayHave) {
  const auto own = RunWithForce(
      29, 1500, ",peak_N=1000,peak_Nm=50,continuous_N=1000,continuous_Nm=50", 500, {30, 1});
  EXPECT_EQ(own->process->limits().force, 30);
  EXPECT_LE(own->All().most, 30 + 1e-9);
  EXPECT_LE(own->All().step, 5 + 1e-9);
}

TEST(DeviceProcess, ABadPoseAnUnwellDriverAndAButtonEndTheForce) {
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

TEST(DeviceProcess, AHandleThatLeapsGetsNoForce) {
  const auto own = RunWithForce(2.4, 1500, ",jump_at=1100");
  const std::vector<FakeRecord::Write> writes = own->motor.Since(0);
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
TEST(DeviceProcess, ADriverThatHangsIsAnOverrun) {
  const auto own = RunWithForce(1.9, 850, ",hang_at=800,hang_ms=30");
  EXPECT_EQ(own->motor.force(), 0);
  EXPECT_GE(own->process->Newest()->counts.zeroed, 1U);
}

TEST(DeviceProcess, ACrashOfItsOwnLeavesNoForce) {
  const auto own = RunWithForce(2.0, 1300, ",crash_at=1000");
  EXPECT_EQ(own->motor.force(), 0);
  EXPECT_THAT(own->process->News(), ::testing::HasSubstr("the device process ended"));
  EXPECT_EQ(own->process->News(), "");  // said once
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
  bool WaitForEnd(double seconds) {
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

TEST(DeviceProcess, NoSignalLeavesAForceAtTheMotor) {
  for (const int signal : {SIGTERM, SIGHUP,  SIGUSR1, SIGUSR2, SIGALRM,   SIGVTALRM, SIGPROF,
                           SIGIO,   SIGXCPU, SIGXFSZ, SIGPWR,  SIGSTKFLT, SIGRTMIN,  SIGRTMAX,
                           SIGSYS,  SIGTRAP, SIGSEGV, SIGBUS,  SIGFPE,    SIGILL,    SIGABRT}) {
    RunningController own("");
    ASSERT_TRUE(own.motor.WaitForForce(0.5));
    kill(own.process->pid(), signal);
    EXPECT_TRUE(own.WaitForEnd(2)) << strsignal(signal);
    EXPECT_EQ(own.motor.force(), 0) << strsignal(signal);
  }
}

TEST(DeviceProcess, WhatATerminalSendsIsTheControllersToAnswer) {
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
TEST(DeviceProcess, ADriverThatRunsOutOfItsStackLeavesNoForce) {
  RunningController own(",recurse_at=1500");
  ASSERT_TRUE(own.motor.WaitForForce(1.0));
  EXPECT_TRUE(own.WaitForEnd(5));
  EXPECT_EQ(own.motor.force(), 0);
}

TEST(DeviceProcess, ADriverThatHangsForEverLeavesNoForceAndEndsWhenItIsToldTo) {
  RunningController own(",hang_at=1500,hang_ms=1e6");
  ASSERT_TRUE(own.motor.WaitForForce(1.0));
  EmptyLoop empty;
  own.motor.WaitForNoForce();
  const double late_ms = empty.WorstMs();
  EXPECT_EQ(own.motor.force(), 0);
  const std::vector<FakeRecord::Write> writes = own.motor.Since(0);
  const auto zero = std::find_if(writes.rbegin(), writes.rend(), [](const auto& write) {
    return Motor::ForceOf(write) > 0;
  });
  ASSERT_NE(zero, writes.rbegin());
  const double kept_ms = 1e-6 * static_cast<double>(std::prev(zero)->ns - zero->ns);
  std::printf("a read that hangs: the motor kept its force for %.1f ms\n", kept_ms);
  // 20 ms, and the check after that
  EXPECT_GE(kept_ms, 15);
  EXPECT_LE(kept_ms, 60 + late_ms);
  kill(own.process->pid(), SIGTERM);
  EXPECT_TRUE(own.WaitForEnd(0.5));
  EXPECT_EQ(own.motor.force(), 0);
}

TEST(DeviceProcess, ADriverThatHangsWhileItOpensEndsWhenItIsToldTo) {
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
  EXPECT_TRUE(process->Wait(std::chrono::milliseconds(1000)));
}

// The vendor's thread goes on asking while the loop stands still in a read.
TEST(DeviceProcess, AVendorsThreadGetsNoForceFromALoopThatStandsStill) {
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
    const std::vector<FakeRecord::Write> writes = own.motor.Since(0);
    // The force was not cut when it was 20 ms old. It had fallen by then, from 5 ms of age on, by
    // half a newton a millisecond. Between two writes it may fall by no more, however late this
    // machine makes the second.
    const auto last = std::find_if(writes.rbegin(), writes.rend(), [](const auto& write) {
      return Motor::ForceOf(write) > 0;
    });
    ASSERT_NE(last, writes.rend());
    ASSERT_NE(last, writes.rbegin());
    const double gap_ms = 1e-6 * static_cast<double>(std::prev(last)->ns - last->ns);
    if (gap_ms * kMillisecond < MotorGuard::kMostGapNs) {
      EXPECT_LT(Motor::ForceOf(*last), 3.0 / MotorGuard::kSlewTicks * gap_ms + 0.25) << rate;
      ++judged;
    }
    const DeviceTimes times = own.process->times();
    const double late_ms = empty.WorstMs();
    std::printf("a vendor's thread of %s Hz takes what is %.2f ms old in the mean, %.2f at most\n",
                rate, 1e-6 * static_cast<double>(times.asked_mean_ns),
                1e-6 * static_cast<double>(times.asked_max_ns));
    EXPECT_GT(times.asked, 50U) << rate;
    // the phase of the two loops adds from nothing to a period
    EXPECT_LE(1e-6 * static_cast<double>(times.asked_mean_ns),
              1e3 / std::stod(rate) + 0.1 * late_ms)
        << rate << " Hz; an empty loop was late by " << late_ms << " ms";
  }
  EXPECT_GE(judged, 1);
}

TEST(DeviceProcess, TellsWhatItsLoopWasGrantedAndHowOftenItTicks) {
  const auto process = DeviceProcess::Start({.driver = "fake:rate_hz=500", .core = 1023});
  ASSERT_TRUE(process);
  EXPECT_THAT((*process)->scheduler(), ::testing::StartsWith("SCHED_"));
  EXPECT_THAT((*process)->warning(), ::testing::HasSubstr("core 1023 cannot be had"));
  EXPECT_EQ((*process)->period_ns(), 2 * kMillisecond);
}

TEST(DeviceProcess, ItsPassivityControlIsAskedForAndToldOf) {
  for (const bool control : {false, true}) {
    const auto process = DeviceProcess::Start({.driver = "fake:", .passivity_control = control});
    ASSERT_TRUE(process);
    Sleep(0.05);
    EXPECT_EQ((*process)->Newest()->passivity.control, control);
  }
}

TEST(DeviceProcess, EndsInAnOrderlyWayWhenItIsToldTo) {
  OwnController own("");
  own.device->Start();
  for (int i = 0; i < 40 && own.motor.force() <= 2; ++i) own.Run(250);
  ASSERT_GT(own.motor.force(), 2);
  std::atomic<bool> end{false};
  std::thread running([&] {
    while (!end) own.Run(10);
  });
  own.process->End();
  end = true;
  running.join();
  EXPECT_EQ(own.motor.force(), 0);
  EXPECT_LE(own.All().step, kSlew + 1e-9);
}

TEST(DeviceProcess, SaysWhyThereIsNoDevice) {
  const auto none = DeviceProcess::Start({.driver = "omega:7"});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().what, ::testing::HasSubstr("no driver is called 'omega'"));
  const auto wrong = DeviceProcess::Start({.driver = "fake:peak_N=lots"});
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().what, ::testing::HasSubstr("a number is wanted, not 'lots'"));
}

TEST(DeviceProcess, TheProgramAloneSaysWhatStartsIt) {
  const std::string run = std::string(TANDEM_DEVICE) +
                          " --driver none: --memory 0 </dev/null "
                          "2>/dev/null";
  EXPECT_EQ(WEXITSTATUS(std::system(run.c_str())), 6);
  const std::string bare = std::string(TANDEM_DEVICE) + " 2>/dev/null";
  EXPECT_EQ(WEXITSTATUS(std::system(bare.c_str())), 2);
}

}  // namespace
}  // namespace tandem
