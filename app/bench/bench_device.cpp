#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/bench/bench_commands.h"
#include "app/bench/measure/bench_scene.h"
#include "app/bench/measure/empty_work.h"
#include "app/bench/measure/timed_frames.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "app/process/device_process.h"
#include "engine/base/text/json_text.h"
#include "engine/haptics/hand_script.h"
#include "engine/realtime/periodic_thread.h"
#include "engine/safety/force_guard.h"
#include "engine/world/world.h"

namespace tandem {
namespace {

constexpr std::int64_t kTickNs = 1'000'000;
/// The device and empty loops take turns of this length, because the machine's other work changes.
constexpr int kRoundTicks = 30'000;

struct DeviceBenchArguments {
  BenchScene scene{.scene = "bracket_actuator"};
  int ticks = 10'000;
  int core = -1;
  int device_core = -1;
  int busy = 0;
  bool json = false;
  std::string driver;  // empty: the scene's hand file
};

struct DeviceFigures {
  Histogram frame_cpu, frame_wall, noise;
  std::int64_t in_contact = 0;
  std::int64_t frames = 0;
  long page_faults = 0;
  std::uint64_t missed = 0;
  std::uint64_t empty_missed = 0;
  int rounds = 0;
  DeviceTimes times;  // sums over the rounds; quantiles and the like of the worst
  std::string device_scheduler;
  const char* scheduler = "";
};

/// Keeps processes running that never rest.
class BusyProcesses {
 public:
  explicit BusyProcesses(int count) {
    for (int i = 0; i < count; ++i) {
      const pid_t pid = fork();
      if (pid > 0) pids_.push_back(pid);
      if (pid != 0) continue;
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      for (std::atomic<std::uint64_t> n{0};;) n.fetch_add(1, std::memory_order_relaxed);
    }
  }
  ~BusyProcesses() {
    for (const pid_t pid : pids_) {
      kill(pid, SIGKILL);
      waitpid(pid, nullptr, 0);
    }
  }
  BusyProcesses(const BusyProcesses&) = delete;
  BusyProcesses& operator=(const BusyProcesses&) = delete;

 private:
  std::vector<pid_t> pids_;
};

/// Returns the page faults of the calling thread.
long FaultsOfThread() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

/// Returns how many deadlines a loop misses that does nothing.
std::uint64_t EmptyMissed(int ticks, int core) {
  PeriodicThread thread({.priority = kFramePriority, .core = core},
                        [ticks](std::int64_t frame, std::int64_t) {
                          return frame + 1 < ticks;
                        });
  thread.Join();
  return thread.stats().missed();
}

/// Runs a frame of a body in a hand: the input, the step, the answer.
class DeviceFrame {
 public:
  DeviceFrame(World& world, Device& device, const Pose& X_BD, const FrameCapacity& capacity)
      : world_(&world), device_(&device), X_BD_(X_BD), guard_(device.capabilities().peak) {
    inputs_ = ParkedInputs(world.model());
    inputs_.instances[0].drive = BodyDrive::kSimulated;
    inputs_.capacity = capacity.tests;
    inputs_.query_price = capacity.query_price;
    inputs_.hand = {.body = 0,
                    .X_BD = X_BD,
                    .goal = {},
                    .gains = LimitGains(device.capabilities(),
                                        DefaultHandGains(world.model().bodies[0].inertia))};
  }
  /// Runs a frame and returns the step's report. `cpu_ns`, `wall_ns`: its times without the link to
  /// the device.
  const StepReport& operator()(std::int64_t& cpu_ns, std::int64_t& wall_ns) {
    LoopClock& clock = MachineClock();
    inputs_.hand.goal = device_->Read();
    const std::int64_t wall = clock.NowNs();
    const std::int64_t cpu = clock.ThreadCpuNs();
    report_ = world_->Step(inputs_);
    const Wrench& on_body = report_.hand_B_W;
    const Vec3 r = world_->state(0).X_WB.q * X_BD_.p;
    const Wrench given = guard_.Pass({-(on_body.tau - r.cross(on_body.f)), -on_body.f});
    cpu_ns = clock.ThreadCpuNs() - cpu;
    wall_ns = clock.NowNs() - wall;
    device_->Render(given);
    return report_;
  }

 private:
  World* world_;
  Device* device_;
  Pose X_BD_;
  ForceGuard guard_;
  StepInputs inputs_;
  StepReport report_;
};

void RunTicks(DeviceFrame& frame, DeviceProcess& process, Device& device, int ticks, int core,
              DeviceFigures& figures) {
  std::int64_t counted = 0;
  device.Start();
  PeriodicThread thread({.period_ns = kTickNs,
                         .origin_ns = process.origin_ns(),
                         .priority = kFramePriority,
                         .core = core},
                        [&](std::int64_t number, std::int64_t) {
                          std::int64_t cpu_ns = 0;
                          std::int64_t wall_ns = 0;
                          const long faults = FaultsOfThread();
                          const StepReport& report = frame(cpu_ns, wall_ns);
                          const long new_faults = FaultsOfThread() - faults;
                          if (number < kWarmUp) return true;
                          figures.page_faults += new_faults;
                          figures.frame_cpu.Add(cpu_ns);
                          figures.frame_wall.Add(wall_ns);
                          figures.in_contact += report.contact_points > 0 ? 1 : 0;
                          ++figures.frames;
                          return ++counted < ticks;
                        });
  thread.Join();
  figures.missed += thread.stats().missed();
  figures.scheduler = thread.realtime().scheduler();
  if (!thread.realtime().warning.empty()) Say(thread.realtime().warning);
}

/// Runs ticks of empty work, as long as most frames. The machine causes their variation.
void RunEmptyWork(int ticks, int core, DeviceFigures& figures) {
  EmptyWork work;
  work.Size(static_cast<double>(figures.frame_cpu.Quantile(0.5)));
  PeriodicThread thread({.priority = kFramePriority, .core = core},
                        [&](std::int64_t number, std::int64_t) {
                          const std::int64_t begun_ns = MachineClock().NowNs();
                          work();
                          figures.noise.Add(MachineClock().NowNs() - begun_ns);
                          return number + 1 < ticks;
                        });
  thread.Join();
}

double InUs(std::int64_t ns) {
  return 1e-3 * static_cast<double>(ns);
}

void Add(const DeviceTimes& round, DeviceTimes& all) {
  all.ticks += round.ticks;
  all.answered += round.answered;
  all.unanswered += round.unanswered;
  all.late += round.late;
  all.missed += round.missed;
  all.requested += round.requested;
  all.read_to_write_p50_ns = std::max(all.read_to_write_p50_ns, round.read_to_write_p50_ns);
  all.read_to_write_p99_ns = std::max(all.read_to_write_p99_ns, round.read_to_write_p99_ns);
  all.read_to_write_max_ns = std::max(all.read_to_write_max_ns, round.read_to_write_max_ns);
  all.asked_mean_ns = std::max(all.asked_mean_ns, round.asked_mean_ns);
  all.asked_max_ns = std::max(all.asked_max_ns, round.asked_max_ns);
}

/// Runs a device process and its frames. An empty loop of half as many ticks runs before and after.
/// Ticks of empty work follow, a tenth as many.
std::optional<Error> RunRound(const std::shared_ptr<const WorldModel>& model,
                              const HandScript& script, const FrameCapacity& capacity,
                              const std::string& driver, int ticks,
                              const DeviceBenchArguments& arguments, DeviceFigures& figures) {
  figures.empty_missed += EmptyMissed(ticks / 2, arguments.core);
  Result<std::unique_ptr<DeviceProcess>> process =
      DeviceProcess::Start({.driver = driver,
                            .home_W = model->bodies[0].X_WB0,
                            .users = DeviceLimits{},
                            .core = arguments.device_core});
  if (!process) return process.error();
  const std::unique_ptr<Device> device = (*process)->MakeDevice();
  World world(model);
  DeviceFrame frame(world, *device, script.X_BD, capacity);
  RunTicks(frame, **process, *device, ticks, arguments.core, figures);
  (*process)->End();  // nobody answers the device after this
  Add((*process)->times(), figures.times);
  figures.device_scheduler = (*process)->scheduler();
  ++figures.rounds;
  RunEmptyWork(ticks / 10, arguments.core, figures);
  figures.empty_missed += EmptyMissed(ticks - ticks / 2, arguments.core);
  return std::nullopt;
}

double ContactShare(const DeviceFigures& figures) {
  return static_cast<double>(figures.in_contact) / static_cast<double>(figures.frames);
}

nlohmann::ordered_json AsJson(const DeviceFigures& figures, const std::string& scene, int busy) {
  const DeviceTimes& times = figures.times;
  return {{"scene", scene},
          {"scheduler", figures.scheduler},
          {"ticks", figures.frames},
          {"busy_processes", busy},
          {"read_to_write_p50_us", InUs(times.read_to_write_p50_ns)},
          {"read_to_write_p99_us", InUs(times.read_to_write_p99_ns)},
          {"read_to_write_max_us", InUs(times.read_to_write_max_ns)},
          {"frame_cpu_p99_us", InUs(figures.frame_cpu.Quantile(0.99))},
          {"frame_wall_p99_us", InUs(figures.frame_wall.Quantile(0.99))},
          {"noise_p50_us", InUs(figures.noise.Quantile(0.5))},
          {"noise_p99_us", InUs(figures.noise.Quantile(0.99))},
          {"missed", figures.missed},
          {"empty_missed", figures.empty_missed},
          {"rounds", figures.rounds},
          {"page_faults", figures.page_faults},
          {"contact_share", ContactShare(figures)},
          {"answered", times.answered},
          {"unanswered", times.unanswered},
          {"unanswered_share", times.unanswered_share()},
          {"late", times.late},
          {"device_scheduler", figures.device_scheduler},
          {"asked", times.requested},
          {"asked_age_mean_us", InUs(times.asked_mean_ns)},
          {"asked_age_max_us", InUs(times.asked_max_ns)},
          {"device_missed", times.missed}};
}

void PrintFigures(const DeviceFigures& figures) {
  const DeviceTimes& times = figures.times;
  std::printf("%ld ticks of a device process in %d rounds, %s, contact in %.0f %% of them\n",
              static_cast<long>(figures.frames), figures.rounds, figures.scheduler,
              100 * ContactShare(figures));
  std::printf("  input to motor  p50 %.1f us, p99 %.1f us, at most %.1f us, of the worst round\n",
              InUs(times.read_to_write_p50_ns), InUs(times.read_to_write_p99_ns),
              InUs(times.read_to_write_max_ns));
  std::printf("  not answered in their tick: %.3f %% of the inputs; their times count too\n",
              100 * times.unanswered_share());
  if (times.requested > 0) {
    std::printf(
        "  the vendor's thread takes forces that are %.1f us old in the mean, at most %.1f us\n",
        InUs(times.asked_mean_ns), InUs(times.asked_max_ns));
  }
  std::printf(
      "  of that, a frame takes p99 %.1f us (processor %.1f us); empty work of that length %.1f "
      "us\n",
      InUs(figures.frame_wall.Quantile(0.99)), InUs(figures.frame_cpu.Quantile(0.99)),
      InUs(figures.noise.Quantile(0.99)));
  std::printf("  deadlines       %llu missed, an empty loop %llu; the device %llu\n",
              static_cast<unsigned long long>(figures.missed),
              static_cast<unsigned long long>(figures.empty_missed),
              static_cast<unsigned long long>(times.missed));
  std::printf("  page faults     %ld\n", figures.page_faults);
}

int RunDeviceBench(const DeviceBenchArguments& arguments) {
  const BusyProcesses busy(arguments.busy);  // before there are threads
  BenchScene requested = arguments.scene;
  requested.needs_fixture = true;
  const auto model = LoadBenchScene(requested);
  if (!model) return Fail(kExitFile, model.error().what);
  if ((*model)->scene.hands.empty())
    return Fail(kExitFile, requested.scene + ": the scene has no hand");
  const std::string file = (*model)->scene.hands[0].file;
  const Result<HandScript> script = LoadHandScript(file);
  if (!script) return Fail(kExitFile, script.error().what);
  const FrameCapacity capacity = MeasureCapacity(**model, kFrameBudget, nullptr);
  const std::string driver = arguments.driver.empty() ? "scripted:" + file : arguments.driver;

  DeviceFigures figures;
  const int rounds = (arguments.ticks + kRoundTicks - 1) / kRoundTicks;
  for (int round = 0; round < rounds; ++round) {
    const int ticks = arguments.ticks / rounds + (round < arguments.ticks % rounds ? 1 : 0);
    const std::optional<Error> fault =
        RunRound(*model, *script, capacity, driver, ticks, arguments, figures);
    if (fault) return Fail(kExitDevice, fault->what);
  }
  if (arguments.json) {
    std::printf("%s\n", JsonText(AsJson(figures, requested.scene, arguments.busy), 2).c_str());
  } else {
    PrintFigures(figures);
  }
  return kExitOk;
}

}  // namespace

void AddBenchDevice(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<DeviceBenchArguments>();
  CLI::App* command = bench.add_subcommand("device",
                                           "Measure the time from a device's input to its motor, "
                                           "with the device in a process of its own");
  AddBenchScene(*command, arguments->scene);
  command
      ->add_option("--ticks", arguments->ticks, "number of ticks to measure, of a millisecond each")
      ->check(WholeNumberFrom(1000, 10'000'000))
      ->capture_default_str();
  command->add_option("--core", arguments->core, "processor core of the frames")
      ->check(WholeNumberFrom(0, 1023));
  command
      ->add_option("--device-core", arguments->device_core, "processor core of the device process")
      ->check(WholeNumberFrom(0, 1023));
  command->add_option("--driver", arguments->driver,
                      "driver of the device, as NAME:OPTIONS; default: the scene's scripted hand");
  command
      ->add_option("--busy", arguments->busy, "number of processes that keep cores busy meanwhile")
      ->check(WholeNumberFrom(0, 64))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunDeviceBench(*arguments);
  });
}

}  // namespace tandem
