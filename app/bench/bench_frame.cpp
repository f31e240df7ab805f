#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <random>

#include <nlohmann/json.hpp>

#include "app/bench/bench_commands.h"
#include "app/bench/measure/all_points.h"
#include "app/bench/measure/bench_scene.h"
#include "app/bench/measure/scripted_frames.h"
#include "app/bench/measure/test_prices.h"
#include "app/bench/measure/timed_frames.h"
#include "app/bench/reference/printed_schedule.h"
#include "app/capacity/capacity.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "engine/base/text/json_text.h"
#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr int kFreeFrames = 4000;

struct FrameArguments {
  BenchScene scene{.scene = "clutter"};
  int frames = 20000;
  double capacity = 0;                    // points a frame; 0: measured
  double budget_us = 1e6 * kFrameBudget;  // budget of a frame, where capacity is measured
  std::vector<std::string> without;
  std::string schedule = "ours";
  int check_every = 100;  // frames from one look at every point to the next
  int threads = 1;        // threads that share a frame's work
  int passes = 0;         // runs of the same frames, back to back
  bool json = false;
};

/// Repeats the middle of a hand's script, so that the hand stays where the contacts are.
HandScript Working(HandScript script, double seconds) {
  const std::vector<Waypoint> once = script.waypoints;
  if (once.size() < 5) return script;
  script.waypoints.resize(2);
  double t = once[1].t;
  while (t < seconds) {
    for (std::size_t i = 2; i + 2 < once.size(); ++i) {
      Waypoint next = once[i];
      t += once[i].t - once[i - 1].t;
      next.t = t;
      script.waypoints.push_back(next);
    }
    Waypoint back = once[1];
    back.t = t += 1.5;
    script.waypoints.push_back(back);
  }
  return script;
}

/// Returns a place within the fixture's box with nothing near, for the body's centre of mass.
std::optional<Pose> FreePlace(const World& world) {
  AllPoints all(world);
  Bounds box;
  for (std::size_t i = 0; i < world.model().meshes_W.size(); ++i) {
    if (world.model().body_index[i] >= 0) continue;
    const Bounds part = BoundsOf(world.model().meshes_W[i]);
    box.Add(part.min);
    box.Add(part.max);
  }
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < 500; ++i) {
    const Vec3 at(share(random), share(random), share(random));
    Pose X_WB;
    X_WB.p = box.min + at.cwiseProduct(box.size());
    X_WB.q = RotationBy(3 * (Vec3(share(random), share(random), share(random)) * 2 - Vec3::Ones()));
    if (all.AllBeyond(X_WB)) return X_WB;
  }
  return std::nullopt;
}

/// Takes the labels from points: without geometrical awareness every point meets every surface
/// (paper §4).
void ForgetLabels(Pointshell& points) {
  std::fill(points.labels.begin(), points.labels.end(), Label::kVertex);
  for (Pointshell::Chunk& chunk : points.chunks) chunk.labels = {0, 0, chunk.count};
}

/// The world and the limits that the frames of a bench run with.
struct FrameSetup {
  std::shared_ptr<const WorldModel> model;
  ScheduleOptions schedule;
  FrameCapacity capacity;
  double budget_s = 0;  // 0: a capacity from the options stays
};

/// The frames of a bench, among the parts and in free space.
struct FrameRuns {
  FrameFigures figures;
  FrameFigures free;
  bool has_free = false;  // there is a place with nothing near
  TestPrices prices;
  nlohmann::ordered_json back_to_back;

  double count() const { return static_cast<double>(figures.frames); }
  double at_bound() const { return static_cast<double>(figures.at_bound) / count(); }
};

bool IsPlain(const WorldModel& model) {
  return model.scene.contact == ContactModel::kPlain;
}

/// Leaves the savings out that the options name. Error: plain contact alone has one of them.
std::optional<Error> LeaveOut(const std::vector<std::string>& savings, FrameSetup& setup) {
  ExperimentOptions& experiments = setup.schedule.experiments;
  for (const std::string& what : savings) {
    const bool of_points = what == "awareness" || what == "drift";
    if (of_points && !IsPlain(*setup.model)) {
      return Error{"--without " + what + ": only plain contact has this saving"};
    }
    if (what == "coherence") experiments.coherence = experiments.chunks = experiments.drift = false;
    if (what == "chunks") experiments.chunks = false;
    if (what == "drift") experiments.drift = false;
    if (what != "awareness") continue;
    auto blind = std::make_shared<WorldModel>(*setup.model);
    for (BodyModel& body : blind->bodies) ForgetLabels(body.points);
    setup.model = std::move(blind);
  }
  return std::nullopt;
}

/// Runs frames in which the hand leads the body by the script.
void RunAmongParts(const FrameArguments& arguments, const FrameSetup& setup,
                   const HandScript& script, const WorkerPool& workers, FrameRuns& runs) {
  World world(setup.model, setup.schedule);
  const double seconds = 1e-3 * (arguments.frames + kWarmUp);
  const HandScript working = Working(script, seconds);
  ScriptedHand hand(world, working);
  RunFrames(world, std::ref(hand), working.X_BD, setup.capacity, setup.budget_s, arguments.frames,
            arguments.check_every, workers, runs.figures);
  runs.prices = IsPlain(*setup.model) ? MeasureTestPrices(world.point_pair(0)) : TestPrices{};
  runs.back_to_back =
      BackToBackJson(LeastOfPasses(setup.model, setup.schedule, working, setup.capacity,
                                   arguments.frames, arguments.passes),
                     arguments.passes);
}

/// Runs frames at a place with nothing near, if there is one.
void RunInFreeSpace(const FrameArguments& arguments, const FrameSetup& setup,
                    const WorkerPool& workers, FrameRuns& runs) {
  World world(setup.model, setup.schedule);
  const std::optional<Pose> place = FreePlace(world);
  runs.has_free = place.has_value();
  if (!place) return;
  world.Place(0, *place);
  RunFrames(
      world,
      [&](std::int64_t frame, const StepReport&) {
        // the goal goes to and fro and turns, by 20 mm and half a radian, at up to 0.13 m/s
        const double t = 1e-3 * static_cast<double>(frame);
        const Vec3 way = 0.02 * Vec3(std::sin(6 * t), std::sin(5 * t), std::sin(4 * t));
        const Vec3 turn = 0.5 * Vec3(std::sin(0.5 * t), std::sin(0.4 * t), std::sin(0.3 * t));
        return Anchor{{RotationBy(turn) * place->q, place->p + way}, {}};
      },
      Pose{}, setup.capacity, setup.budget_s, kFreeFrames, arguments.check_every, workers,
      runs.free);
}

nlohmann::ordered_json LongestJson(const FrameFigures& figures) {
  return {{"cpu_us", 1e-3 * static_cast<double>(figures.worst_ns)},
          {"contacts", figures.worst.contact_points},
          {"clear", 0},
          {"exact_queries", figures.worst.exact_queries},
          {"looks", figures.worst.exact_queries},  // an earlier key
          {"sifted", 0},
          {"pushing_points", figures.worst.pushing_points},
          {"loaded", figures.worst.pushing_points},
          {"tests", figures.worst.tests.looked_up + figures.worst.tests.compared},
          {"drifted", figures.worst.tests.drifted},
          {"chunks", figures.worst.tests.chunks}};
}

nlohmann::ordered_json FrameJson(const FrameArguments& arguments, const FrameSetup& setup,
                                 const FrameRuns& runs, int threads) {
  const FrameFigures& figures = runs.figures;
  const FrameFigures& free = runs.free;
  const double count = runs.count();
  nlohmann::ordered_json out{
      {"scene", arguments.scene.scene},
      {"without", arguments.without},
      {"schedule", arguments.schedule},
      {"voxel_m", setup.model->scene.voxel_size},
      {"points", TestedPoints(*setup.model, setup.model->bodies[0])},
      {"voxels", FixtureVoxels(*setup.model)},
      {"frames", figures.frames},
      {"threads", threads},
      {"budget_us", arguments.budget_us},
      {"capacity", setup.capacity.tests},
      {"capacity_mean", figures.capacity / count},
      {"query_price", setup.capacity.query_price},
      {"look_price", setup.capacity.query_price},  // earlier key
      {"contacts", figures.contacts / count},
      {"clear", 0},  // no point is known to be clear; the key is for readers of older figures
      {"exact_queries", figures.exact_queries / count},
      {"looks", figures.exact_queries / count},  // earlier key
      {"sifted", 0},                             // as clear
      {"pushing_points", figures.pushing_points / count},
      {"loaded", figures.pushing_points / count},  // earlier key
      {"cpu_p50_us", Us(figures.cpu, 0.5)},
      {"cpu_p99_us", Us(figures.cpu, 0.99)},
      {"cpu_p999_us", Us(figures.cpu, 0.999)},
      {"workers_cpu_p50_us", Us(figures.workers_cpu, 0.5)},
      {"helpers_cpu_p50_us", Us(figures.workers_cpu, 0.5)},  // earlier key
      {"longest", LongestJson(figures)},
      {"back_to_back", runs.back_to_back},
      {"wall_p999_us", Us(figures.wall, 0.999)},
      {"frames_over_1ms", figures.over_1ms},
      {"missed", figures.missed},
      {"noise_p999_us", Us(figures.noise, 0.999)},
      {"tests_per_frame", figures.tests / count},
      {"tests_owed_p50", figures.owed.Quantile(0.5)},
      {"tests_owed_max", figures.owed.max()},
      {"drifted_per_frame", figures.drifted / count},
      {"looked_up_ns", runs.prices.looked_up_ns},
      {"drifted_ns", runs.prices.drifted_ns},
      {"chunks_per_frame", figures.chunks / count},
      {"travel_at_bound_share", runs.at_bound()},
      {"travel_limited_share", static_cast<double>(figures.held_back) / count},
      {"violations", figures.violations + free.violations},
      {"point_frames_checked", figures.point_frames + free.point_frames},
      {"page_faults", figures.page_faults + free.page_faults},
      {"free_cpu_p99_us", nullptr}};
  if (runs.has_free) {
    out["free_cpu_p50_us"] = Us(free.cpu, 0.5);
    out["free_cpu_p99_us"] = Us(free.cpu, 0.99);
    out["free_contacts"] = free.contacts / static_cast<double>(free.frames);
  }
  return out;
}

void PrintTimes(const FrameArguments& arguments, const FrameRuns& runs, int threads) {
  const FrameFigures& figures = runs.figures;
  std::printf("  processor   p50 %.1f us, p99 %.1f us, p99.9 %.1f us\n", Us(figures.cpu, 0.5),
              Us(figures.cpu, 0.99), Us(figures.cpu, 0.999));
  if (threads > 1) {
    std::printf("  workers     p50 %.1f us, of %s together beside the haptic thread\n",
                Us(figures.workers_cpu, 0.5),
                WithPlural(static_cast<std::uint64_t>(threads) - 1, "thread").c_str());
  }
  std::printf("  wall        p99.9 %.1f us; empty work of the same length %.1f us\n",
              Us(figures.wall, 0.999), Us(figures.noise, 0.999));
  std::printf("  deadlines   %ld of %ld frames took more than 1 ms; %ld deadlines missed\n",
              figures.over_1ms, figures.frames, figures.missed);
  if (!runs.back_to_back.is_null()) {
    std::printf(
        "  %d passes back to back, each frame's least time: p50 %.1f us, p99 %.1f us, p99.9 %.1f "
        "us\n",
        arguments.passes, runs.back_to_back["cpu_p50_us"].get<double>(),
        runs.back_to_back["cpu_p99_us"].get<double>(),
        runs.back_to_back["cpu_p999_us"].get<double>());
  }
}

void PrintFrame(const FrameArguments& arguments, const FrameSetup& setup, const FrameRuns& runs,
                int threads) {
  const FrameFigures& figures = runs.figures;
  const FrameFigures& free = runs.free;
  const double count = runs.count();
  std::printf("%zu points against %zu voxels, %.0f contacts, %.0f tests a frame (capacity %.0f)\n",
              TestedPoints(*setup.model, setup.model->bodies[0]), FixtureVoxels(*setup.model),
              figures.contacts / count, figures.tests / count, setup.capacity.tests);
  PrintTimes(arguments, runs, threads);
  std::printf("  drift       %.0f points a frame put back; %.0f chunks examined\n",
              figures.drifted / count, figures.chunks / count);
  if (IsPlain(*setup.model)) {
    const TestPrices& prices = runs.prices;
    std::printf("  a point     look-up %.2f ns, drift test %.2f ns: %.1f times less\n",
                prices.looked_up_ns, prices.drifted_ns, prices.looked_up_ns / prices.drifted_ns);
  }
  std::printf("  pending     p50 %lld tests, max %lld tests in every frame\n",
              static_cast<long long>(figures.owed.Quantile(0.5)),
              static_cast<long long>(figures.owed.max()));
  std::printf("  MaxTravel   at its bound in %.2f %% of the frames\n", 100 * runs.at_bound());
  std::printf("  violations  %zu in %.3g point-frames; %ld page faults\n",
              figures.violations + free.violations, figures.point_frames + free.point_frames,
              figures.page_faults + free.page_faults);
  if (runs.has_free) std::printf("  free space  p99 %.1f us\n", Us(free.cpu, 0.99));
}

int RunFrame(const FrameArguments& arguments) {
  BenchScene requested = arguments.scene;
  requested.needs_fixture = true;
  const auto loaded = LoadBenchScene(requested);
  if (!loaded) return Fail(kExitFile, loaded.error().what);
  FrameSetup setup;
  setup.model = *loaded;
  if (!setup.model->has_fixture)
    return Fail(kExitFile, arguments.scene.scene + ": the scene has no fixed body");
  if (arguments.schedule == "printed") setup.schedule.instead = MakePrintedSchedule;
  if (const auto fault = LeaveOut(arguments.without, setup)) return Fail(kExitUsage, fault->what);
  const Scene& scene = setup.model->scene;
  if (scene.hands.empty())
    return Fail(kExitFile, arguments.scene.scene + ": the scene has no hand");
  const Result<HandScript> script = LoadHandScript(scene.hands[0].file);
  if (!script) return Fail(kExitFile, script.error().what);
  WorkerPool workers({.threads = arguments.threads, .priority = kFramePriority});
  if (workers.threads() > 1) setup.schedule.workers = &workers;
  setup.budget_s = arguments.capacity > 0 ? 0.0 : 1e-6 * arguments.budget_us;
  setup.capacity = arguments.capacity > 0
                       ? FrameCapacity{.tests = arguments.capacity}
                       : MeasureCapacity(*setup.model, setup.budget_s, setup.schedule.workers);

  FrameRuns runs;
  RunAmongParts(arguments, setup, *script, workers, runs);
  RunInFreeSpace(arguments, setup, workers, runs);
  if (arguments.json) {
    const nlohmann::ordered_json out = FrameJson(arguments, setup, runs, workers.threads());
    std::printf("%s\n", JsonText(out, 2).c_str());
  } else {
    PrintFrame(arguments, setup, runs, workers.threads());
  }
  return kExitOk;
}

}  // namespace

void AddBenchFrame(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<FrameArguments>();
  CLI::App* command = bench.add_subcommand(
      "frame", "Measure the time of whole frames of a body among parts, at 1 kHz");
  AddBenchScene(*command, arguments->scene);
  command
      ->add_option("--points", arguments->scene.points,
                   "number of points of the moving body, about, in plain contact; default: one for "
                   "each voxel")
      ->check(WholeNumberFrom(1, 100'000'000));
  command->add_option("--frames", arguments->frames, "number of frames to measure")
      ->check(WholeNumberFrom(1000, 10'000'000))
      ->capture_default_str();
  command
      ->add_option(
          "--capacity", arguments->capacity,
          "point tests in a frame, at most; default: as many as fit into --budget on this machine")
      ->check(NumberAbove(0, 1e9));
  command
      ->add_option("--budget", arguments->budget_us,
                   "time of a frame for its point tests and exact queries, us")
      ->check(NumberFrom(10, 1000))
      ->capture_default_str();
  command
      ->add_option(
          "--without", arguments->without,
          "saving to switch off: coherence or chunks; in plain contact also awareness or drift")
      ->check(OneOf({"awareness", "coherence", "chunks", "drift"}));
  command
      ->add_option("--schedule", arguments->schedule,
                   "schedule: ours, or the paper's rule as printed, which can test a contact late")
      ->check(OneOf({"ours", "printed"}))
      ->capture_default_str();
  command
      ->add_option("--check-every", arguments->check_every,
                   "number of frames between checks of all points for untested contacts")
      ->check(WholeNumberFrom(1, 1'000'000))
      ->capture_default_str();
  command
      ->add_option("--threads", arguments->threads, "number of threads that share a frame's work")
      ->check(WholeNumberFrom(1, WorkerPool::kMostThreads))
      ->capture_default_str();
  command
      ->add_option("--passes", arguments->passes,
                   "number of extra runs of the same frames without pauses, at the capacity of "
                   "the start; the figures take each frame's shortest time; default: none")
      ->check(WholeNumberFrom(1, 1000));
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunFrame(*arguments);
  });
}

}  // namespace tandem
