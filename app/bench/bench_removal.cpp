#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "app/bench/bench_commands.h"
#include "app/bench/measure/removal_pictures.h"
#include "app/bench/measure/scripted_frames.h"
#include "app/capacity/capacity.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/program_cache.h"
#include "app/common/scene_files.h"
#include "app/judgement/demo_judgement.h"
#include "app/picture/svg.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/hash.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

// Seconds after the hand's last waypoint. Times leave out the first kWarmUp frames.
constexpr double kRest = 2.0;

struct RemovalArguments {
  std::string scene = "landing_gear";
  std::string hand;      // hand file; empty: the scene's first
  double points_mm = 0;  // 0: the scene's
  double voxel_mm = 0;   // 0: the scene's
  double capacity = 0;   // points a frame; 0: measured
  double budget_us = 1e6 * kFrameBudget;
  int passes = 10;                 // passes back to back
  std::string plots;               // folder for pictures
  std::uint64_t voxel_memory = 0;  // bytes; 0: all voxels in memory
  double disk_mb_per_s = 0;        // reading rate; 0: what the disk gives
  bool json = false;
};

/// Loads the scene in plain contact, with the voxel and point sizes of the options.
Result<std::shared_ptr<const WorldModel>> LoadRemoval(const RemovalArguments& arguments) {
  Result<Scene> scene = LoadNamedScene(arguments.scene);
  if (!scene) return scene.error();
  if (scene->contact != ContactModel::kPlain) {
    scene->contact = ContactModel::kPlain;
    scene->force_layer = DefaultForceLayer(ContactModel::kPlain);
  }
  if (arguments.voxel_mm > 0) scene->voxel_size = 1e-3 * arguments.voxel_mm;
  if (arguments.points_mm > 0) {
    const double spacing = 1e-3 * arguments.points_mm / scene->voxel_size;
    if (spacing > 1) {
      char text[100];
      std::snprintf(text, sizeof text, "--points-mm: expected at most the voxel size, %g mm",
                    1e3 * scene->voxel_size);
      return Error{text};
    }
    for (SceneBody& body : scene->bodies) body.point_spacing_voxels = spacing;
  }
  return LoadAndTell(*scene, {.voxel_memory_bytes = arguments.voxel_memory,
                              .disk_bytes_per_s = 1e6 * arguments.disk_mb_per_s});
}

/// Returns the memory that voxels of the fixed bodies took in a world, bytes.
std::size_t VoxelMemory(const World& world) {
  const ResidentVoxels* resident = world.resident_voxels();
  return resident != nullptr ? resident->bytes() : world.model().fixture.Count().bytes;
}

/// Returns the most memory that this program has had in use, bytes.
std::size_t PeakBytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) << 10U;
}

/// A removal to run: a scene, the hand's script and the frames' limits.
struct Removal {
  std::shared_ptr<const WorldModel> model;
  HandScript script;
  FrameCapacity capacity;
  double budget_s = 0;  // 0: a capacity from the options stays
  int frames = 0;
};

/// The findings of a removal's run.
struct RemovalRun {
  RemovalTrace trace;
  FrameFigures figures;
  Hash64 poses;
  std::size_t voxel_bytes = 0;
  ResidentCounts paged;
  Outcome outcome;
  int most_contacts = 0;
  float most_force = 0;
  Histogram least;  // least times of the passes back to back

  double count() const { return static_cast<double>(figures.frames); }
  double at_bound() const { return static_cast<double>(figures.at_bound) / count(); }
};

/// Returns the file of the hand that the options name, or of the scene's first hand.
Result<std::filesystem::path> HandFileOf(const RemovalArguments& arguments,
                                         const WorldModel& model) {
  if (!arguments.hand.empty()) return std::filesystem::path(arguments.hand);
  if (model.scene.hands.empty()) {
    return Error{arguments.scene + ": the scene has no hand; give one with --hand"};
  }
  if (model.BodyNamed(model.scene.hands[0].body) != 0) {
    return Error{arguments.scene + ": the first hand must hold the first moving body"};
  }
  return model.scene.hands[0].file;
}

Result<Removal> PrepareRemoval(const RemovalArguments& arguments) {
  const auto loaded = LoadRemoval(arguments);
  if (!loaded) return loaded.error();
  Removal removal;
  removal.model = *loaded;
  if (!removal.model->has_fixture) return Error{arguments.scene + ": the scene has no fixed body"};
  const Result<std::filesystem::path> file = HandFileOf(arguments, *removal.model);
  if (!file) return file.error();
  Result<HandScript> script = LoadHandScript(*file);
  if (!script) return script.error();
  removal.script = *std::move(script);
  if (!arguments.plots.empty()) {
    std::error_code failed;
    std::filesystem::create_directories(arguments.plots, failed);
    if (failed) return Error{arguments.plots + ": " + failed.message()};
  }
  removal.budget_s = arguments.capacity > 0 ? 0.0 : 1e-6 * arguments.budget_us;
  removal.capacity = arguments.capacity > 0
                         ? FrameCapacity{.tests = arguments.capacity}
                         : MeasureCapacity(*removal.model, removal.budget_s, nullptr);
  removal.frames =
      static_cast<int>(std::lround(1e3 * (removal.script.duration() + kRest))) - kWarmUp;
  return removal;
}

/// Runs the removal once at 1 kHz. Error: voxels did not come.
std::optional<Error> RunOnceTimed(const Removal& removal, const WorkerPool& workers,
                                  RemovalRun& run) {
  World world(removal.model, ScheduleOptions());
  ScriptedHand hand(world, removal.script);
  run.trace.frames.reserve(static_cast<std::size_t>(removal.frames + kWarmUp));
  RunFrames(
      world,
      [&](std::int64_t frame, const StepReport& report) {
        run.trace.frames.push_back({.contact_N = static_cast<float>(report.contact_B_W.f.norm()),
                                    .hand_N = static_cast<float>(report.hand_B_W.f.norm()),
                                    .contacts = report.contact_points});
        const Pose& X_WB = world.state(0).X_WB;
        run.poses.AddBytes(X_WB.p.data(), sizeof X_WB.p);
        run.poses.AddBytes(X_WB.q.coeffs().data(), 4 * sizeof(double));
        return hand(frame, report);
      },
      removal.script.X_BD, removal.capacity, removal.budget_s, removal.frames, removal.frames,
      workers, run.figures);
  run.voxel_bytes = VoxelMemory(world);
  if (world.resident_voxels() != nullptr) run.paged = world.resident_voxels()->counts();
  if (run.figures.waits.longest >= kLongestVoxelWait) return Error{world.MissingVoxelsReason()};
  run.outcome = OutcomeOf(*removal.model, 0, world.state(0).X_WB);
  for (const RemovalTrace::Frame& frame : run.trace.frames) {
    run.most_contacts = std::max(run.most_contacts, frame.contacts);
    run.most_force = std::max(run.most_force, frame.hand_N);
  }
  return std::nullopt;
}

std::optional<Error> WritePlots(const std::string& folder, const RemovalRun& run) {
  if (folder.empty()) return std::nullopt;
  for (const Picture& picture : RemovalPictures(run.trace, run.figures.cpu, run.least)) {
    const std::filesystem::path to = std::filesystem::path(folder) / (picture.name + ".svg");
    if (auto fault = WriteWholeFile(to, SvgOf(picture, SvgPlace::kFile))) return fault;
  }
  return std::nullopt;
}

nlohmann::ordered_json RemovalJson(const RemovalArguments& arguments, const Removal& removal,
                                   const RemovalRun& run) {
  const FrameFigures& figures = run.figures;
  const double count = run.count();
  return {{"scene", arguments.scene},
          {"voxel_mm", 1e3 * removal.model->scene.voxel_size},
          {"points", TestedPoints(*removal.model, removal.model->bodies[0])},
          {"voxels", FixtureVoxels(*removal.model)},
          {"out", run.outcome.out},
          {"travel_m", run.outcome.travel},
          {"frames", figures.frames},
          {"capacity", removal.capacity.tests},
          {"cpu_p50_us", Us(figures.cpu, 0.5)},
          {"cpu_p99_us", Us(figures.cpu, 0.99)},
          {"cpu_p999_us", Us(figures.cpu, 0.999)},
          {"noise_p999_us", Us(figures.noise, 0.999)},
          {"missed", figures.missed},
          {"back_to_back", BackToBackJson(run.least, arguments.passes)},
          {"travel_at_bound_share", run.at_bound()},
          {"travel_limited_share", static_cast<double>(figures.held_back) / count},
          {"contacts_mean", figures.contacts / count},
          {"contacts_max", run.most_contacts},
          {"hand_force_max_N", run.most_force},
          {"stalls", figures.waits.count},
          {"stall_s", 1e-3 * static_cast<double>(figures.waits.frames)},
          {"longest_stall_ms", figures.waits.longest},
          {"pages_read", run.paged.pages_read},
          {"pages_given_up", run.paged.pages_given_up},
          {"page_faults", figures.page_faults},
          {"poses_digest", Hex(run.poses.value())},
          {"peak_bytes", PeakBytes()},
          {"voxel_memory_bytes", run.voxel_bytes}};
}

void PrintRemoval(const RemovalArguments& arguments, const Removal& removal,
                  const RemovalRun& run) {
  const FrameFigures& figures = run.figures;
  std::printf("%zu points against %zu voxels: the part moved %.0f mm and is %s\n",
              TestedPoints(*removal.model, removal.model->bodies[0]), FixtureVoxels(*removal.model),
              1e3 * run.outcome.travel, run.outcome.out ? "out" : "NOT out");
  std::printf("  contacts    %.0f a frame, at most %d; at most %.1f N in the hand\n",
              figures.contacts / run.count(), run.most_contacts,
              static_cast<double>(run.most_force));
  std::printf("  processor   p50 %.1f us, p99 %.1f us, p99.9 %.1f us; empty work p99.9 %.1f us\n",
              Us(figures.cpu, 0.5), Us(figures.cpu, 0.99), Us(figures.cpu, 0.999),
              Us(figures.noise, 0.999));
  if (arguments.passes > 0) {
    std::printf(
        "  %d passes back to back, each frame's least time: p50 %.1f us, p99 %.1f us, p99.9 %.1f "
        "us\n",
        arguments.passes, Us(run.least, 0.5), Us(run.least, 0.99), Us(run.least, 0.999));
  }
  std::printf("  MaxTravel   at its bound in %.2f %% of %ld frames; %ld deadlines missed\n",
              100 * run.at_bound(), figures.frames, figures.missed);
  if (arguments.voxel_memory > 0) {
    std::printf(
        "  stalls      %ld, %.3f s together, the longest %d ms; %llu pages read, %llu given up\n",
        figures.waits.count, 1e-3 * static_cast<double>(figures.waits.frames),
        figures.waits.longest, static_cast<unsigned long long>(run.paged.pages_read),
        static_cast<unsigned long long>(run.paged.pages_given_up));
  }
  std::printf("  memory      %.0f MB of voxels, peak %.0f MB in all; %ld page faults\n",
              1e-6 * static_cast<double>(run.voxel_bytes), 1e-6 * static_cast<double>(PeakBytes()),
              figures.page_faults);
}

int RunRemoval(const RemovalArguments& arguments) {
  const Result<Removal> removal = PrepareRemoval(arguments);
  if (!removal) return Fail(kExitFile, removal.error().what);
  const WorkerPool workers({.threads = 1, .priority = kFramePriority});
  RemovalRun run;
  if (const auto fault = RunOnceTimed(*removal, workers, run)) return Fail(kExitFile, fault->what);
  // the first world is gone: else its voxels would be in memory twice
  run.least = LeastOfPasses(removal->model, ScheduleOptions(), removal->script, removal->capacity,
                            removal->frames, arguments.passes);
  if (const auto fault = WritePlots(arguments.plots, run)) return Fail(kExitFile, fault->what);
  if (arguments.json) {
    std::printf("%s\n", JsonText(RemovalJson(arguments, *removal, run), 2).c_str());
  } else {
    PrintRemoval(arguments, *removal, run);
  }
  return kExitOk;
}

}  // namespace

void AddBenchRemoval(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<RemovalArguments>();
  CLI::App* command = bench.add_subcommand("removal",
                                           "Measure a removal: a hand takes a part out through "
                                           "contact at 1 kHz, and again without pauses");
  command->add_option("--scene", arguments->scene, "name of a scene, or a scene file")
      ->capture_default_str();
  command->add_option("--hand", arguments->hand, "hand file; default: the scene's first hand");
  command
      ->add_option("--points-mm", arguments->points_mm,
                   "spacing of the part's points, mm; default: the scene's")
      ->check(NumberFrom(1e-3, 1e4));
  command->add_option("--voxel-mm", arguments->voxel_mm, "voxel size, mm; default: the scene's")
      ->check(NumberFrom(1e3 * kLeastVoxel, 1e3 * kLargestVoxel));
  command
      ->add_option(
          "--capacity", arguments->capacity,
          "point tests in a frame, at most; default: as many as fit into --budget on this machine")
      ->check(NumberAbove(0, 1e9));
  command->add_option("--budget", arguments->budget_us, "time of a frame for its point tests, us")
      ->check(NumberFrom(10, 1000))
      ->capture_default_str();
  command->add_option("--passes", arguments->passes, "number of runs back to back")
      ->check(WholeNumberFrom(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--voxel-memory", arguments->voxel_memory,
                   "memory for the fixed bodies' voxels, at most, such as 512MiB; the rest is read "
                   "as needed; default: all voxels stay in memory")
      ->transform(SizeInBytes());
  command
      ->add_option("--disk-mb-per-s", arguments->disk_mb_per_s,
                   "greatest speed of reading voxels, MB/s")
      ->check(NumberAbove(0, 1e6));
  command->add_option("--plots", arguments->plots,
                      "folder for pictures: frame times, contacts, forces");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunRemoval(*arguments);
  });
}

}  // namespace tandem
