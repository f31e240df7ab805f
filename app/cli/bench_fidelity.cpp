#include "app/cli/bench_fidelity.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/cli/bench.h"
#include "app/cli/scene_files.h"
#include "app/cli/talk.h"
#include "app/exit_codes.h"
#include "app/option_checks.h"
#include "engine/base/json_text.h"

namespace tandem {

namespace {

using nlohmann::ordered_json;

struct FidelityArguments {
  std::string models;
  int approaches = 1000;
  int tilts = 50;
  int peg_seeds = 100;
  double nut_voxel = 0.0001;  // m
  double peg_voxel = 0.00005;
  std::vector<std::string> only;  // of kFigures; none: all
  bool json = false;

  bool Asks(const char* figure) const {
    return only.empty() || std::find(only.begin(), only.end(), figure) != only.end();
  }
};

constexpr std::array<const char*, 5> kFigures{"first-force", "pressed", "nut", "pegs", "ball"};

ordered_json AsJson(const Spread& spread) {
  return {{"min", spread.min}, {"mean", spread.mean}, {"max", spread.max}};
}

/// Adds what frames take, by the names that all parts have.
ordered_json With(ordered_json out, const FrameLengths& frames) {
  out["frame_cpu_p50_us"] = frames.cpu_p50_us;
  out["frame_cpu_p99_us"] = frames.cpu_p99_us;
  out["frame_wall_p999_us"] = frames.wall_p999_us;
  out["frames"] = frames.frames;
  out["frames_over_1ms"] = frames.over_1ms;
  out["missed"] = frames.missed;
  return out;
}

/// Least, mean and largest over the three bodies, and each body's own.
ordered_json FirstForce(ContactModel contact, const FidelityArguments& arguments) {
  if (!arguments.Asks("first-force")) return nullptr;
  constexpr std::array<const char*, 3> kNames{"sphere", "box", "cylinder"};
  Spread all;
  ordered_json bodies;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const Spread spread = MeasureFirstForce(contact, static_cast<Approaching>(i), arguments.tilts,
                                            arguments.approaches);
    all.min = i == 0 ? spread.min : std::min(all.min, spread.min);
    all.max = i == 0 ? spread.max : std::max(all.max, spread.max);
    all.mean += spread.mean / kNames.size();
    bodies[kNames[i]] = AsJson(spread);
  }
  ordered_json out = AsJson(all);
  out.update(bodies);
  return out;
}

ordered_json Nut(ContactModel contact, const FidelityArguments& arguments, int& exit_code) {
  if (arguments.models.empty() || !arguments.Asks("nut")) return nullptr;
  const Result<NutFigures> nut = MeasureNut(contact, arguments.models, arguments.nut_voxel);
  if (!nut) {
    exit_code = Fail(kExitFile, nut.error().what);
    return nullptr;
  }
  return With({{"voxel_mm", 1e3 * nut->voxel},
               {"force_layer", DefaultForceLayer(contact)},
               {"turned_deg", nut->turned * 57.29577951308232},
               {"helix_error_mm", nut->helix_error_mm},
               {"push_mm", nut->push_mm},
               {"axial_blocked", nut->axial_blocked}},
              nut->frames);
}

ordered_json Pegs(ContactModel contact, const FidelityArguments& arguments, int& exit_code) {
  if (arguments.models.empty() || !arguments.Asks("pegs")) return nullptr;
  const Result<PegFigures> pegs =
      MeasurePegs(contact, arguments.models, arguments.peg_voxel, arguments.peg_seeds);
  if (!pegs) {
    exit_code = Fail(kExitFile, pegs.error().what);
    return nullptr;
  }
  return With({{"voxel_mm", 1e3 * pegs->voxel},
               {"force_layer", DefaultForceLayer(contact)},
               {"trials", pegs->trials},
               {"inserted_share", pegs->inserted_share},
               {"buzz", pegs->buzz}},
              pegs->frames);
}

ordered_json Ball(ContactModel contact, const FidelityArguments& arguments, int& exit_code) {
  if (!arguments.Asks("ball")) return nullptr;
  const Result<BallFigures> ball = MeasureBall(contact, SceneFile("ball_and_socket"));
  if (!ball) {
    exit_code = Fail(kExitFile, ball.error().what);
    return nullptr;
  }
  return With({{"points_035", ball->points_035},
               {"points_015", ball->points_015},
               {"turn_s", ball->turn_s},
               {"turn_1khz_s", ball->turn_1khz_s},
               {"contacts_mean", ball->contacts_mean}},
              ball->frames);
}

/// What is not asked for is null; what cannot be measured too, and said, and in the exit code.
ordered_json Measure(ContactModel contact, const FidelityArguments& arguments, int& exit_code) {
  ordered_json direction;
  ordered_json ripple;
  ordered_json ripple_max;
  if (arguments.Asks("pressed")) {
    const PressedFigures pressed = MeasurePressed(contact, arguments.tilts);
    direction = {{"mean", pressed.direction_error_mean}, {"max", pressed.direction_error_max}};
    ripple = pressed.ripple;
    ripple_max = pressed.ripple_max;
  }
  return {{"first_force_gap_voxels", FirstForce(contact, arguments)},
          {"direction_error_deg", direction},
          {"sliding_ripple", ripple},
          {"sliding_ripple_max", ripple_max},
          {"nut", Nut(contact, arguments, exit_code)},
          {"pegs", Pegs(contact, arguments, exit_code)},
          {"ball", Ball(contact, arguments, exit_code)}};
}

int RunFidelity(FidelityArguments arguments) {
  if (arguments.models.empty()) {
    if (const char* models = std::getenv("TANDEM_MODELS")) arguments.models = models;
  }
  if (arguments.models.empty() && (arguments.Asks("nut") || arguments.Asks("pegs"))) {
    Say("no nut and no pegs: give the folder of models/factory with --models or TANDEM_MODELS");
  }
  int exit_code = kExitOk;
  ordered_json out = Measure(ContactModel::kRefined, arguments, exit_code);
  out["plain"] = Measure(ContactModel::kPlain, arguments, exit_code);
  if (arguments.json) {
    std::printf("%s\n", JsonText(out, 2).c_str());
    return exit_code;
  }
  const ordered_json plain = out["plain"];
  out.erase("plain");
  for (const auto& [name, figures] : out.items()) {
    std::printf("%-22s refined %s\n%-22s plain   %s\n", name.c_str(), JsonText(figures).c_str(), "",
                JsonText(plain[name]).c_str());
  }
  return exit_code;
}

}  // namespace

void AddBenchFidelity(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<FidelityArguments>();
  CLI::App* command =
      bench.add_subcommand("fidelity", "How near contact comes to exact surfaces, in all models");
  command->add_option("--models", arguments->models,
                      "folder that holds factory/, for the nut and the pegs");
  command->add_option("--approaches", arguments->approaches, "of each body, for first forces")
      ->check(WholeNumberFrom(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--tilts", arguments->tilts, "of planes")
      ->check(WholeNumberFrom(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--pegs", arguments->peg_seeds, "how many pegs are put in")
      ->check(WholeNumberFrom(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--nut-voxel", arguments->nut_voxel, "voxel size for the nut, metres")
      ->check(NumberFrom(kLeastVoxel, kLargestVoxel))
      ->capture_default_str();
  command->add_option("--peg-voxel", arguments->peg_voxel, "voxel size for the pegs, metres")
      ->check(NumberFrom(kLeastVoxel, kLargestVoxel))
      ->capture_default_str();
  command->add_option("--only", arguments->only, "what to measure; default: all")
      ->check(OneOf({kFigures.begin(), kFigures.end()}));
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunFidelity(*arguments);
  });
}

}  // namespace tandem
