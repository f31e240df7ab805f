#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/stability/cli/stability_command.h"
#include "app/stability/live/lab_scenes.h"
#include "collab/lab/case/case_parts.h"
#include "collab/lab/case/lab_scene.h"
#include "collab/lab/run/bisection.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double kLeastRatio = 0.95;
constexpr double kMostRatio = 1.25;
constexpr double kFarthest = 4;     // ratio up to which a boundary is sought
constexpr double kLongDelay = 0.1;  // s; from this delay on, a link's body and arm move as one

struct BoundaryArguments {
  std::vector<std::string> hands = {"off", "heavy"};
  std::vector<double> delays_s = {0.1, 0.3, 1.0};
  std::string law = "constant";
  double damping = 10;
  double relative_damping = 0;
  std::size_t users = 2;
  double publish_hz = 1000;
  double jitter_ms = 0;
  double loss = 0;
  std::vector<std::uint64_t> seeds = {1};
  double seconds = 0;
  unsigned jobs = 0;
  bool json = false;
};

struct Row {
  LabCase test;
  BoundaryPoint point;

  /// Returns whether the bars hold for the row: two users on a clean line, whose hands lend the
  /// link no spring.
  bool is_judged() const {
    return test.users == 2 && test.network.name == "clean" &&
           test.hands[0].impedance.stiffness == 0 && test.law.limits.constant_link_damping == 0 &&
           test.law.name == "constant";
  }
  bool passes() const {
    if (point.fault) return false;
    if (!is_judged()) return true;
    const bool is_short = test.delay_s < kLongDelay;
    return point.ratio() >= kLeastRatio && (is_short || point.ratio() <= kMostRatio);
  }
};

/// Returns a name such as "jitter 20 ms, loss 5 %".
std::string NameOf(double jitter_ms, double loss) {
  char text[64];
  std::snprintf(text, sizeof text, "jitter %g ms, loss %g %%", jitter_ms, 1e2 * loss);
  return text;
}

Result<std::vector<Row>> RowsOf(const BoundaryArguments& arguments, const Inertia& body) {
  std::vector<Row> rows;
  for (const std::string& name : arguments.hands) {
    const Result<LabHand> hand = HandNamed(name, body);
    if (!hand) return hand.error();
    for (const double delay_s : arguments.delays_s) {
      LabNetwork network;
      if (arguments.jitter_ms > 0 || arguments.loss > 0) {
        network.name = NameOf(arguments.jitter_ms, arguments.loss);
        network.there = {.jitter_ms = arguments.jitter_ms, .loss = arguments.loss};
        network.back = network.there;
      }
      Row row;
      row.test.network = network;
      row.test.users = arguments.users;
      row.test.hands = {*hand};
      row.test.law.name = arguments.law;
      row.test.law.limits.constant_damping = arguments.damping;
      row.test.law.limits.constant_link_damping = arguments.relative_damping;
      row.test.law.gate = false;
      row.test.delay_s = delay_s;
      row.test.publish_hz = arguments.publish_hz;
      row.test.seconds = arguments.seconds;
      for (const std::uint64_t seed : arguments.seeds) {
        row.test.seed = seed;
        rows.push_back(row);
      }
    }
  }
  return rows;
}

/// Finds all boundaries on `jobs` threads, the longest delay first.
void FindAll(std::vector<Row>& rows, const LabScene& scene, unsigned jobs) {
  std::vector<Row*> order;
  for (Row& row : rows) order.push_back(&row);
  std::stable_sort(order.begin(), order.end(), [](const Row* a, const Row* b) {
    return a->test.delay_s > b->test.delay_s;
  });
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t i = next++; i < order.size(); i = next++) {
      order[i]->point = FindBoundary(order[i]->test, scene);
    }
  };
  std::vector<std::thread> others;
  for (unsigned i = 1; i < jobs; ++i) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
}

OrderedJson JsonOf(const Row& row) {
  OrderedJson json = {{"hand", row.test.hands[0].name},
                      {"delay_s", row.test.delay_s},
                      {"law", row.test.law.name},
                      {"users", row.test.users},
                      {"network", row.test.network.name},
                      {"seed", row.test.seed},
                      {"predicted_N_m", row.point.predicted},
                      {"onset_hz", row.point.onset_hz},
                      {"runs", row.point.runs},
                      {"judged", row.is_judged()},
                      {"pass", row.passes()}};
  if (row.point.fault) {
    json["fault"] = row.point.fault->what;
    return json;
  }
  // null: none was found, and JSON has no infinity
  const bool found = std::isfinite(row.point.measured);
  json["measured_N_m"] = found ? OrderedJson(row.point.measured) : OrderedJson();
  json["ratio"] = found ? OrderedJson(row.point.ratio()) : OrderedJson();
  return json;
}

/// Returns a row of a report's table of claims.
OrderedJson ClaimOf(const Row& row) {
  const bool is_short = row.test.delay_s < kLongDelay;
  char name[96];
  std::snprintf(name, sizeof name, "boundary over the exact one, hands %s, %g ms",
                row.test.hands[0].name.c_str(), 1e3 * row.test.delay_s);
  const double ratio = std::isfinite(row.point.measured) ? row.point.ratio() : kFarthest;
  return {{"name", name},
          {"bar", is_short ? ">= 0.95" : "0.95 to 1.25"},
          {"value", row.point.fault ? 0.0 : ratio},
          {"pass", row.passes()}};
}

void Print(const std::vector<Row>& rows) {
  if (rows.front().test.network.name != "clean") {
    PrintLine("network: %s", rows.front().test.network.name.c_str());
  }
  PrintLine("hand      delay s    seed   exact N/m   measured N/m   ratio   onset Hz");
  for (const Row& row : rows) {
    char found[160];
    if (row.point.fault) {
      std::snprintf(found, sizeof found, "%s", row.point.fault->what.c_str());
    } else if (!std::isfinite(row.point.measured)) {
      std::snprintf(found, sizeof found, "%9.1f   none up to 4 times that", row.point.predicted);
    } else {
      std::snprintf(found, sizeof found, "%9.1f   %12.1f   %5.3f   %8.2f%s", row.point.predicted,
                    row.point.measured, row.point.ratio(), row.point.onset_hz,
                    row.passes() ? "" : "   not within 0.95 to 1.25");
    }
    PrintLine("%-8s %8.3f %7ju   %s", row.test.hands[0].name.c_str(), row.test.delay_s,
              static_cast<std::uintmax_t>(row.test.seed), found);
  }
}

/// Returns whether rows that differ in their seed alone have the same figures, in a clean network.
bool SeedsChangeNothing(const std::vector<Row>& rows) {
  bool compared = false;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Row& row = rows[i];
    const Row& before = rows[i - 1];
    const bool only_seed = row.test.delay_s == before.test.delay_s &&
                           row.test.hands[0].name == before.test.hands[0].name;
    if (!only_seed) continue;
    compared = true;
    if (row.test.network.name != "clean" || row.point.measured != before.point.measured ||
        row.point.onset_hz != before.point.onset_hz) {
      return false;
    }
  }
  return compared;
}

int RunStabilityBoundary(const BoundaryArguments& arguments) {
  const Result<LabScene> scene = LoadLabScene(LabCase{}, LabSceneFolder());
  if (!scene) return Fail(kExitFile, scene.error().what);
  Result<std::vector<Row>> rows = RowsOf(arguments, scene->inertia());
  if (!rows) return Fail(kExitUsage, rows.error().what);
  const unsigned jobs = arguments.jobs > 0 ? arguments.jobs : std::thread::hardware_concurrency();
  FindAll(*rows, *scene, jobs);
  bool pass = true;
  OrderedJson json = OrderedJson::array();
  OrderedJson claims = OrderedJson::array();
  for (const Row& row : *rows) {
    pass = pass && row.passes();
    json.push_back(JsonOf(row));
    if (row.is_judged()) claims.push_back(ClaimOf(row));
  }
  if (arguments.json) {
    PrintText(JsonText(OrderedJson{{"pass", pass}, {"rows", claims}, {"boundary", json}}, 2));
  } else {
    Print(*rows);
  }
  if (SeedsChangeNothing(*rows)) {
    Say("all seeds give the same figures, because nothing is random in a clean network at this "
        "rate: give --jitter-ms or --loss, or one seed");
  }
  return pass ? kExitOk : kExitFailed;
}

}  // namespace

void AddStabilityBoundary(CLI::App& stability, int& exit_code) {
  auto arguments = std::make_shared<BoundaryArguments>();
  CLI::App* command = stability.add_subcommand(
      "boundary",
      "Find by bisection the stiffness at which motion begins to grow, and compare it with the "
      "exact one; exit code 1 if two users with free hands are not within 0.95 to 1.25 of it");
  command->add_option("--hands", arguments->hands, "hands, each off, relaxed, heavy or firm")
      ->delimiter(',')
      ->capture_default_str();
  command->add_option("--delays", arguments->delays_s, "one-way delays, s")
      ->delimiter(',')
      ->check(NumberFrom(0.001, 1.1))
      ->capture_default_str();
  command
      ->add_option("--law", arguments->law,
                   "coupling law whose drags count; its stiffness is searched for")
      ->check(OneOf(LawNames(true)))
      ->capture_default_str();
  command
      ->add_option("--damping", arguments->damping,
                   "with --law constant: drag against the ground, N s/m")
      ->check(NumberFrom(0.1, 100))
      ->capture_default_str();
  command
      ->add_option("--relative-damping", arguments->relative_damping,
                   "with --law constant: drag between the instances, N s/m")
      ->check(NumberFrom(0, 100))
      ->capture_default_str();
  command->add_option("--users", arguments->users, "number of users")
      ->check(WholeNumberFrom(2, 8))
      ->capture_default_str();
  command->add_option("--publish-hz", arguments->publish_hz, "states that each user sends, Hz")
      ->check(NumberFrom(10, 1000))
      ->capture_default_str();
  command
      ->add_option("--jitter-ms", arguments->jitter_ms,
                   "greatest further delay of a sample, at random, ms")
      ->check(NumberFrom(0, 1000))
      ->capture_default_str();
  command->add_option("--loss", arguments->loss, "share of samples lost, 0 to 1")
      ->check(NumberFrom(0, 0.9))
      ->capture_default_str();
  command
      ->add_option(
          "--seeds", arguments->seeds,
          "random seeds of jitter, loss and the senders' phases; each gets a boundary of its own")
      ->delimiter(',')
      ->check(WholeNumberFrom(1, 2'000'000'000))
      ->capture_default_str();
  command
      ->add_option("--seconds", arguments->seconds,
                   "length of each run, s; 0: 60 s, or 300 delays where that is more")
      ->check(NumberFrom(0, 3600))
      ->capture_default_str();
  command->add_option("--jobs", arguments->jobs, "number of threads; 0: one for each processor")
      ->check(WholeNumberFrom(0, 256));
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunStabilityBoundary(*arguments);
  });
}

}  // namespace tandem
