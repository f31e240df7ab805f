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

#include "app/cli/bench.h"
#include "app/cli/capacity.h"
#include "app/cli/demo_judgement.h"
#include "app/cli/program_cache.h"
#include "app/cli/removal_pictures.h"
#include "app/cli/scene_files.h"
#include "app/cli/scripted_frames.h"
#include "app/cli/talk.h"
#include "app/exit_codes.h"
#include "app/option_checks.h"
#include "app/picture/svg.h"
#include "engine/base/hash.h"
#include "engine/base/json_text.h"
#include "engine/base/whole_file.h"

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
      std::snprintf(text, sizeof text, "--points-mm: at most the voxel size, %g mm",
                    1e3 * scene->voxel_size);
      return Error{text};
    }
    for (SceneBody& body : scene->bodies) body.point_spacing_voxels = spacing;
  }
  return LoadCached(*scene, {.voxel_memory_bytes = arguments.voxel_memory,
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

int RunRemoval(const RemovalArguments& arguments) {
  const auto loaded = LoadRemoval(arguments);
  if (!loaded) return Fail(kExitFile, loaded.error().what);
  const std::shared_ptr<const WorldModel>& model = *loaded;
  if (!model->has_fixture) return Fail(kExitFile, arguments.scene + ": no fixed body");
  if (arguments.hand.empty() && model->scene.hands.empty()) {
    return Fail(kExitFile, arguments.scene + ": no hand; give one by --hand");
  }
  if (arguments.hand.empty() && model->BodyNamed(model->scene.hands[0].body) != 0) {
    return Fail(kExitFile, arguments.scene + ": the first hand is to hold the first moving body");
  }
  const std::filesystem::path file =
      arguments.hand.empty() ? model->scene.hands[0].file : std::filesystem::path(arguments.hand);
  const Result<HandScript> script = LoadHandScript(file);
  if (!script) return Fail(kExitFile, script.error().what);

  if (!arguments.plots.empty()) {
    std::error_code failed;
    std::filesystem::create_directories(arguments.plots, failed);
    if (failed) return Fail(kExitFile, arguments.plots + ": " + failed.message());
  }

  const FrameHelpers helpers({.threads = 1, .priority = kFramePriority});
  const ScheduleOptions schedule;
  // a capacity from the options stays
  const double budget_s = arguments.capacity > 0 ? 0.0 : 1e-6 * arguments.budget_us;
  const FrameCapacity capacity = arguments.capacity > 0
                                     ? FrameCapacity{.tests = arguments.capacity}
                                     : MeasureCapacity(*model, budget_s, nullptr);
  const int frames = static_cast<int>(std::lround(1e3 * (script->duration() + kRest))) - kWarmUp;

  std::optional<World> made(std::in_place, model, schedule);
  World& world = *made;
  ScriptedHand hand(world, *script);
  RemovalTrace trace;
  trace.frames.reserve(static_cast<std::size_t>(frames + kWarmUp));
  FrameFigures figures;
  Hash64 poses;
  RunFrames(
      world,
      [&](std::int64_t frame, const StepReport& report) {
        trace.frames.push_back({.contact_N = static_cast<float>(report.contact_B_W.f.norm()),
                                .hand_N = static_cast<float>(report.hand_B_W.f.norm()),
                                .contacts = report.contact_points});
        const Pose& X_WB = world.state(0).X_WB;
        poses.AddBytes(X_WB.p.data(), sizeof X_WB.p);
        poses.AddBytes(X_WB.q.coeffs().data(), 4 * sizeof(double));
        return hand(frame, report);
      },
      script->X_BD, capacity, budget_s, frames, frames, helpers, figures);
  const std::size_t voxel_bytes = VoxelMemory(world);
  ResidentCounts paged;
  if (world.resident_voxels() != nullptr) paged = world.resident_voxels()->counts();
  if (figures.waits.longest >= kLongestVoxelWait) {
    return Fail(kExitFile, world.WhyVoxelsLack());
  }
  const Outcome outcome = OutcomeOf(*model, 0, world.state(0).X_WB);
  made.reset();  // else its voxels would be in memory twice
  const Histogram least =
      LeastOfPasses(model, schedule, *script, capacity, frames, arguments.passes);

  const auto count = static_cast<double>(figures.frames);
  const double at_bound = static_cast<double>(figures.at_bound) / count;
  int most_contacts = 0;
  float most_force = 0;
  for (const RemovalTrace::Frame& frame : trace.frames) {
    most_contacts = std::max(most_contacts, frame.contacts);
    most_force = std::max(most_force, frame.hand_N);
  }
  if (!arguments.plots.empty()) {
    for (const Picture& picture : RemovalPictures(trace, figures.cpu, least)) {
      const std::filesystem::path to =
          std::filesystem::path(arguments.plots) / (picture.name + ".svg");
      if (const auto fault = WriteWholeFile(to, SvgOf(picture, SvgPlace::kFile))) {
        return Fail(kExitFile, fault->what);
      }
    }
  }
  const std::size_t points = TestedPoints(*model, model->bodies[0]);
  const std::size_t voxels = FixtureVoxels(*model);
  if (arguments.json) {
    const nlohmann::ordered_json out{
        {"scene", arguments.scene},
        {"voxel_mm", 1e3 * model->scene.voxel_size},
        {"points", points},
        {"voxels", voxels},
        {"out", outcome.out},
        {"travel_m", outcome.travel},
        {"frames", figures.frames},
        {"capacity", capacity.tests},
        {"cpu_p50_us", Us(figures.cpu, 0.5)},
        {"cpu_p99_us", Us(figures.cpu, 0.99)},
        {"cpu_p999_us", Us(figures.cpu, 0.999)},
        {"noise_p999_us", Us(figures.noise, 0.999)},
        {"missed", figures.missed},
        {"back_to_back", BackToBackJson(least, arguments.passes)},
        {"travel_at_bound_share", at_bound},
        {"travel_limited_share", static_cast<double>(figures.held_back) / count},
        {"contacts_mean", figures.contacts / count},
        {"contacts_max", most_contacts},
        {"hand_force_max_N", most_force},
        {"stalls", figures.waits.count},
        {"stall_s", 1e-3 * static_cast<double>(figures.waits.frames)},
        {"longest_stall_ms", figures.waits.longest},
        {"pages_read", paged.pages_read},
        {"pages_given_up", paged.pages_given_up},
        {"page_faults", figures.page_faults},
        {"poses_digest", Hex(poses.value())},
        {"peak_bytes", PeakBytes()},
        {"voxel_memory_bytes", voxel_bytes}};
    std::printf("%s\n", JsonText(out, 2).c_str());
    return kExitOk;
  }
  std::printf("%zu points against %zu voxels: the part moved %.0f mm and is %s\n", points, voxels,
              1e3 * outcome.travel, outcome.out ? "out" : "NOT out");
  std::printf("  contacts    %.0f a frame, at most %d; at most %.1f N in the hand\n",
              figures.contacts / count, most_contacts, static_cast<double>(most_force));
  std::printf("  processor   p50 %.1f us, p99 %.1f us, p99.9 %.1f us; empty work p99.9 %.1f us\n",
              Us(figures.cpu, 0.5), Us(figures.cpu, 0.99), Us(figures.cpu, 0.999),
              Us(figures.noise, 0.999));
  if (arguments.passes > 0) {
    std::printf(
        "  of %d passes back to back, each frame's least: p50 %.1f us, p99 %.1f us, p99.9 "
        "%.1f us\n",
        arguments.passes, Us(least, 0.5), Us(least, 0.99), Us(least, 0.999));
  }
  std::printf("  MaxTravel   at its bound in %.2f %% of %ld frames; %ld deadlines missed\n",
              100 * at_bound, figures.frames, figures.missed);
  if (arguments.voxel_memory > 0) {
    std::printf(
        "  stalls      %ld, %.3f s in all, the longest %d ms; %llu pages read, %llu given up\n",
        figures.waits.count, 1e-3 * static_cast<double>(figures.waits.frames),
        figures.waits.longest, static_cast<unsigned long long>(paged.pages_read),
        static_cast<unsigned long long>(paged.pages_given_up));
  }
  std::printf("  memory      %.0f MB of voxels, %.0f MB at most in all; %ld page faults\n",
              1e-6 * static_cast<double>(voxel_bytes), 1e-6 * static_cast<double>(PeakBytes()),
              figures.page_faults);
  return kExitOk;
}

}  // namespace

void AddBenchRemoval(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<RemovalArguments>();
  CLI::App* command = bench.add_subcommand(
      "removal",
      "A hand takes a part out through contact, at 1 kHz, and then again without pauses");
  command->add_option("--scene", arguments->scene, "a scene of tandem's by name, or a scene file")
      ->capture_default_str();
  command->add_option("--hand", arguments->hand, "hand file; default: the scene's first");
  command
      ->add_option("--points-mm", arguments->points_mm,
                   "distance of the part's points in millimetres; default: the scene's")
      ->check(NumberFrom(1e-3, 1e4));
  command
      ->add_option("--voxel-mm", arguments->voxel_mm,
                   "voxel size in millimetres; default: the scene's")
      ->check(NumberFrom(1e3 * kLeastVoxel, 1e3 * kLargestVoxel));
  command
      ->add_option("--capacity", arguments->capacity,
                   "points that may be tested in a frame; default: what fits --budget here")
      ->check(NumberAbove(0, 1e9));
  command->add_option("--budget", arguments->budget_us, "microseconds of a frame for its tests")
      ->check(NumberFrom(10, 1000))
      ->capture_default_str();
  command->add_option("--passes", arguments->passes, "runs back to back")
      ->check(WholeNumberFrom(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--voxel-memory", arguments->voxel_memory,
                   "most memory for the fixed bodies' voxels, such as 512MiB: the rest is read as "
                   "it is needed; default: all are in memory")
      ->transform(SizeInBytes());
  command
      ->add_option("--disk-mb-per-s", arguments->disk_mb_per_s,
                   "reads voxels no faster than so many megabytes a second")
      ->check(NumberAbove(0, 1e6));
  command->add_option("--plots", arguments->plots,
                      "folder to write pictures into: frame times, contacts, forces");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunRemoval(*arguments);
  });
}

}  // namespace tandem
