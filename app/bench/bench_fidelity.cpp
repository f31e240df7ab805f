#include <algorithm>
#include <array>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/bench/bench_commands.h"
#include "app/bench/fidelity/fidelity.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/scene_files.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using nlohmann::ordered_json;

struct FidelityArguments {
  std::string models;
  int approaches = 1000;
  int tilts = 50;
  int peg_seeds = 100;
  int holds = kMostHolds;
  int sheet_tries = 1000;
  int clearance_tilts = 8;
  std::size_t contacts = 100'000;  // contacts whose pushes are judged, about
  double nut_voxel = 0.0001;       // m
  double peg_voxel = 0.00005;
  std::vector<std::string> only;  // some of kFigures; none: all
  bool json = false;

  bool Asks(const char* figure) const {
    return only.empty() || std::find(only.begin(), only.end(), figure) != only.end();
  }
};

constexpr std::array<const char*, 10> kFigures{"first-force", "pressed",  "nut",      "nut-tight",
                                               "pegs",        "ball",     "ball-015", "holds",
                                               "sheets",      "clearance"};
constexpr double kBallVoxel = 0.00035;  // m
constexpr double kFineBallVoxel = 0.00015;

/// Sums over the parts that are measured.
struct Together {
  int parts = 0;
  std::uint64_t dropped = 0;
  std::uint64_t over_1ms = 0;
  int checked = 0;  // parts that have been checked
  ContactChecks checks;

  void Add(const FrameLengths& frames) {
    ++parts;
    dropped += frames.dropped;
    over_1ms += frames.over_1ms;
  }
  void Add(const ContactChecks& of_part) {
    ++checked;
    checks += of_part;
  }
};

ordered_json AsJson(const Spread& spread) {
  return {{"min", spread.min}, {"mean", spread.mean}, {"max", spread.max}};
}

/// Adds the times of frames, by the names that all parts have.
ordered_json With(ordered_json out, const FrameLengths& frames) {
  out["frame_cpu_p50_us"] = frames.cpu_p50_us;
  out["frame_cpu_p99_us"] = frames.cpu_p99_us;
  out["frame_wall_p999_us"] = frames.wall_p999_us;
  out["frames"] = frames.frames;
  out["frames_over_1ms"] = frames.over_1ms;
  out["missed"] = frames.missed;
  out["dropped_frames"] = frames.dropped;
  return out;
}

/// Says why a part cannot be measured, and gives null for it.
ordered_json Unmeasured(const Error& error, int& exit_code) {
  exit_code = Fail(kExitFile, error.what);
  return nullptr;
}

/// Measures the gap at the first force: least, mean and largest over the three bodies, and each
/// body's own.
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

constexpr double Degrees(double radians) {
  return radians * 57.29577951308232;
}

ordered_json Nut(ContactModel contact, const FidelityArguments& arguments, Together& together,
                 int& exit_code) {
  if (arguments.models.empty() || !arguments.Asks("nut")) return nullptr;
  const Result<NutFigures> nut =
      MeasureNut(contact, arguments.models, arguments.nut_voxel, arguments.contacts / 2);
  if (!nut) return Unmeasured(nut.error(), exit_code);
  together.Add(nut->frames);
  together.Add(nut->checks);
  return With({{"voxel_mm", 1e3 * nut->voxel},
               {"force_layer", DefaultForceLayer(contact)},
               {"turned_deg", Degrees(nut->turned)},
               {"helix_error_mm", nut->helix_error_mm},
               {"push_mm", nut->push_mm},
               {"axial_blocked", nut->axial_blocked},
               {"largest_force_step_N", nut->largest_force_step}},
              nut->frames);
}

ordered_json TightNut(ContactModel contact, const FidelityArguments& arguments, Together& together,
                      int& exit_code) {
  if (arguments.models.empty() || !arguments.Asks("nut-tight")) return nullptr;
  const Result<TightNutFigures> nut =
      MeasureTightNut(contact, arguments.models, arguments.nut_voxel);
  if (!nut) return Unmeasured(nut.error(), exit_code);
  together.Add(nut->frames);
  return With({{"voxel_mm", 1e3 * nut->voxel},
               {"force_layer", DefaultForceLayer(contact)},
               {"turned_deg", Degrees(nut->turned)},
               {"helix_error_mm", nut->helix_error_mm},
               {"crossing_mm", nut->crossing_mm}},
              nut->frames);
}

ordered_json Pegs(ContactModel contact, const FidelityArguments& arguments, Together& together,
                  int& exit_code) {
  if (arguments.models.empty() || !arguments.Asks("pegs")) return nullptr;
  const Result<PegFigures> pegs = MeasurePegs(contact, arguments.models, arguments.peg_voxel,
                                              arguments.peg_seeds, arguments.contacts / 2);
  if (!pegs) return Unmeasured(pegs.error(), exit_code);
  together.Add(pegs->frames);
  together.Add(pegs->checks);
  return With({{"voxel_mm", 1e3 * pegs->voxel},
               {"force_layer", DefaultForceLayer(contact)},
               {"trials", pegs->trials},
               {"inserted_share", pegs->inserted_share},
               {"buzz", pegs->buzz}},
              pegs->frames);
}

/// Measures the ball at its usual voxel size, or at the fine one.
ordered_json Ball(ContactModel contact, const FidelityArguments& arguments, bool fine,
                  Together& together, int& exit_code) {
  if (!arguments.Asks(fine ? "ball-015" : "ball")) return nullptr;
  const std::filesystem::path file = SceneFile("ball_and_socket");
  const Result<BallFigures> ball = MeasureBall(contact, file, fine ? kFineBallVoxel : kBallVoxel);
  if (!ball) return Unmeasured(ball.error(), exit_code);
  together.Add(ball->frames);
  ordered_json out{{fine ? "points_015" : "points_035", ball->points}};
  if (!fine) {
    const Result<std::size_t> points = CountBallPoints(contact, file, kFineBallVoxel);
    if (!points) return Unmeasured(points.error(), exit_code);
    out["points_015"] = *points;
  }
  out["turn_s"] = ball->turn_s;
  out["turn_1khz_s"] = ball->turn_1khz_s;
  out["contacts_mean"] = ball->contacts_mean;
  return With(out, ball->frames);
}

/// Measures held balls. Plain contact begins too far off for a ball to be free in so close a
/// hollow.
ordered_json Holds(ContactModel contact, const FidelityArguments& arguments, Together& together) {
  if (contact == ContactModel::kPlain || !arguments.Asks("holds")) return nullptr;
  const HoldFigures holds = MeasureHolds(arguments.holds);
  together.Add(holds.frames);
  return With({{"count", holds.count},
               {"moving", holds.moving},
               {"largest_force_step_N", holds.largest_force_step}},
              holds.frames);
}

/// Measures sheets. Plain contact holds no body on its side of a sheet that is thinner than a
/// voxel.
ordered_json Sheets(ContactModel contact, const FidelityArguments& arguments) {
  if (contact == ContactModel::kPlain || !arguments.Asks("sheets")) return nullptr;
  const SheetFigures sheets = MeasureSheets(arguments.sheet_tries);
  return {{"tries", sheets.tries},
          {"crossings", sheets.crossings},
          {"nearest_voxels", sheets.nearest_voxels}};
}

/// Measures a sweep of the clearance. Plain contact does not begin at a distance of surfaces.
ordered_json ClearanceSweep(ContactModel contact, const FidelityArguments& arguments) {
  if (contact == ContactModel::kPlain || !arguments.Asks("clearance")) return nullptr;
  const ClearanceFigures clearance = MeasureClearance(arguments.clearance_tilts);
  return {{"error_voxels_max", clearance.error_voxels_max},
          {"outer_error_voxels_max", clearance.outer_error_voxels_max},
          {"late_voxels_max", clearance.late_voxels_max},
          {"force_step_N", clearance.force_step}};
}

/// Adds the figures of nut and pegs together, and of all parts.
void AddTogether(const Together& together, ordered_json& out) {
  const FalsePushes& pushes = together.checks.pushes;
  out["dropped_frames"] = together.parts > 0 ? ordered_json(together.dropped) : nullptr;
  out["frames_over_1ms"] = together.parts > 0 ? ordered_json(together.over_1ms) : nullptr;
  // plain contact claims no place and no direction of exact surfaces, so none of its pushes are
  // judged
  out["false_pushes"] = pushes.contacts == 0
                            ? ordered_json()
                            : ordered_json{{"contacts", pushes.contacts},
                                           {"farther_than_0_6_voxel", pushes.farther},
                                           {"askew_by_10_deg", pushes.askew},
                                           {"share_of_force", pushes.force_share()}};
  const bool checked = together.checked > 0;
  const ContactChecks& checks = together.checks;
  out["wrench_error_N"] = checked ? ordered_json(checks.wrench_error) : nullptr;
  out["wrench_error_held_back_N"] = checked ? ordered_json(checks.wrench_error_held_back) : nullptr;
}

/// Returns null for a figure that is not asked for, or that cannot be measured. The latter is said
/// too, and sets the exit code.
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
  Together together;
  ordered_json out;
  out["first_force_gap_voxels"] = FirstForce(contact, arguments);
  out["direction_error_deg"] = direction;
  out["sliding_ripple"] = ripple;
  out["sliding_ripple_max"] = ripple_max;
  out["nut"] = Nut(contact, arguments, together, exit_code);
  out["nut_tight"] = TightNut(contact, arguments, together, exit_code);
  out["pegs"] = Pegs(contact, arguments, together, exit_code);
  out["ball"] = Ball(contact, arguments, false, together, exit_code);
  out["ball_015"] = Ball(contact, arguments, true, together, exit_code);
  out["holds"] = Holds(contact, arguments, together);
  out["sheets"] = Sheets(contact, arguments);
  out["clearance"] = ClearanceSweep(contact, arguments);
  AddTogether(together, out);
  return out;
}

int RunFidelity(FidelityArguments arguments) {
  if (arguments.models.empty()) {
    if (const char* models = std::getenv("TANDEM_MODELS")) arguments.models = models;
  }
  if (arguments.models.empty() &&
      (arguments.Asks("nut") || arguments.Asks("nut-tight") || arguments.Asks("pegs"))) {
    Say("no nuts and no pegs: give the folder of models/factory with --models or TANDEM_MODELS");
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
    std::printf("%-24s refined %s\n%-24s plain   %s\n", name.c_str(), JsonText(figures).c_str(), "",
                JsonText(plain[name]).c_str());
  }
  return exit_code;
}

}  // namespace

void AddBenchFidelity(CLI::App& bench, int& exit_code) {
  auto arguments = std::make_shared<FidelityArguments>();
  CLI::App* command = bench.add_subcommand(
      "fidelity", "Measure how well contact agrees with exact surfaces, in all contact models");
  command->add_option("--models", arguments->models,
                      "folder that contains factory/, for the nuts and the pegs");
  command
      ->add_option("--approaches", arguments->approaches,
                   "number of frames per body, for the first forces")
      ->check(WholeNumberFrom(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--tilts", arguments->tilts, "number of planes")
      ->check(WholeNumberFrom(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--pegs", arguments->peg_seeds, "number of pegs to put in")
      ->check(WholeNumberFrom(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--holds", arguments->holds, "number of close holds of a ball")
      ->check(WholeNumberFrom(1, kMostHolds))
      ->capture_default_str();
  command
      ->add_option("--sheet-tries", arguments->sheet_tries,
                   "number of attempts of a hand to get through a thin sheet")
      ->check(WholeNumberFrom(1, 1'000'000))
      ->capture_default_str();
  command
      ->add_option("--clearance-tilts", arguments->clearance_tilts,
                   "number of planes, for the clearance")
      ->check(WholeNumberFrom(1, 1000))
      ->capture_default_str();
  command
      ->add_option("--contacts", arguments->contacts,
                   "number of pushes of nut and pegs to judge by exact geometry, about")
      ->check(WholeNumberFrom(0, 100'000'000))
      ->capture_default_str();
  command->add_option("--nut-voxel", arguments->nut_voxel, "voxel size for the nuts, m")
      ->check(NumberFrom(kLeastVoxel, kLargestVoxel))
      ->capture_default_str();
  command->add_option("--peg-voxel", arguments->peg_voxel, "voxel size for the pegs, m")
      ->check(NumberFrom(kLeastVoxel, kLargestVoxel))
      ->capture_default_str();
  command->add_option("--only", arguments->only, "figures to measure; default: all")
      ->check(OneOf({kFigures.begin(), kFigures.end()}));
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunFidelity(*arguments);
  });
}

}  // namespace tandem
