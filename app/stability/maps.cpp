#include "app/stability/maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "app/picture/chart.h"
#include "app/stability/cell_facts.h"
#include "collab/lab/case_file.h"
#include "collab/lab/case_parts.h"
#include "collab/lab/prediction.h"

namespace tandem {

namespace {

constexpr int kLinePoints = 96;
constexpr std::size_t kLeastCells = 6;
constexpr double kFirmLinear = 200;  // N/m: the paper's law where it fails

bool IsFree(const LabCase& test) {
  return test.scene == "free" || test.scene == "off_centre";
}

// of the user for whom it is least; no number where the case has no equation
template <class Value>
double LeastOf(const LabCase& test, const Inertia& body, Value value) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t user = 0; user < test.users; ++user) {
    const std::optional<LumpedCoupling> lumped = LumpedOf(test, body, user);
    if (!lumped) return std::numeric_limits<double>::quiet_NaN();
    least = std::min(least, value(*lumped));
  }
  return least;
}

LabCase WithLaw(LabCase test, const std::string& name, double linear_stiffness) {
  test.law = LabLaw{};
  test.law.name = name;
  test.law.limits.linear_stiffness = linear_stiffness;
  return test;
}

template <class Value>
MapLine Line(MapLineKind kind, std::string name, LabCase test, const Inertia& body,
             const std::vector<double>& delays, Value value) {
  MapLine line{kind, std::move(name), {}};
  for (const double delay : delays) {
    test.delay_s = delay;
    line.points.push_back({delay, LeastOf(test, body, value)});
  }
  return line;
}

// several delays, and several stiffnesses at one of them
bool MakesAMap(const std::vector<MapCell>& cells) {
  std::map<double, std::set<double>> columns;
  bool several = false;
  for (const MapCell& cell : cells) {
    columns[cell.delay_s].insert(cell.stiffness);
    several = several || columns[cell.delay_s].size() > 1;
  }
  return cells.size() >= kLeastCells && columns.size() > 1 && several;
}

// A course that ended long ago, at either side, has no slope left: what swings at its bounds no
// longer grows, what is at rest no longer falls.
double ShownGrowth(const CaseResult& result) {
  constexpr double kWild = 0.1;     // m/s at the end
  constexpr double kAtRest = 1e-9;  // m/s
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Metrics& metrics = result.metrics;
  if (metrics.blew_up) return kInfinite;
  if (result.verdict == Verdict::kUnstable && metrics.tail_rms > kWild) return kInfinite;
  if (result.verdict == Verdict::kStable && metrics.tail_rms < kAtRest) return -kInfinite;
  return metrics.growth;
}

MapCell CellOf(const CellRecord& record, const CellFacts& facts) {
  const Metrics& metrics = record.outcome.result.metrics;
  MapCell cell;
  cell.delay_s = facts.delay_s;
  cell.stiffness = StiffnessOf(record, facts);
  cell.growth = ShownGrowth(record.outcome.result);
  cell.verdict = record.outcome.result.verdict;
  cell.hint = LineOf(record, facts) + ": " + NameOf(cell.verdict) + ", " +
              TableNumber(cell.stiffness) + " N/m, growth " + TableNumber(metrics.growth) + "/s";
  return cell;
}

int Rank(Verdict verdict) {
  if (verdict == Verdict::kUnstable) return 2;
  return verdict == Verdict::kUndecided ? 1 : 0;
}

/// The runs of one case with several seeds as one cell: the worst of them.
struct Repeated {
  MapCell worst;
  int runs = 0;
  int stable = 0;

  void Add(const MapCell& cell) {
    ++runs;
    stable += cell.verdict == Verdict::kStable ? 1 : 0;
    const bool worse = runs == 1 || Rank(cell.verdict) > Rank(worst.verdict) ||
                       (cell.verdict == worst.verdict && cell.growth > worst.growth);
    if (worse) worst = cell;
  }
  MapCell Shown() const {
    MapCell cell = worst;
    if (runs > 1) {
      cell.hint += "; the worst of " + std::to_string(runs) + " seeds, " + std::to_string(stable) +
                   " of them stable";
    }
    return cell;
  }
};

struct Group {
  const CellRecord* first = nullptr;
  CellFacts facts;
  std::map<std::string, std::size_t> places;  // of what is repeated, in `cells`
  std::vector<Repeated> cells;
  std::size_t runs = 0;
};

// "constant 20 N/m + 10 N s/m" is of one cell alone: the law without what the
// map varies
std::string LawOnMap(const LabLaw& law) {
  if (law.name != "constant") return law.name;
  std::string text = "constant gains";
  if (law.limits.constant_damping > 0) {
    text += ", drag " + TableNumber(law.limits.constant_damping) + " N s/m";
  }
  if (law.limits.constant_link_damping > 0) {
    text += ", link drag " + TableNumber(law.limits.constant_link_damping) + " N s/m";
  }
  return text;
}

}  // namespace

std::vector<MapLine> LinesOf(const LabCase& like, const Inertia& body, double shortest_s,
                             double longest_s) {
  std::vector<double> delays;
  for (int i = 0; i < kLinePoints; ++i) {
    delays.push_back(shortest_s * std::pow(longest_s / shortest_s, i / (kLinePoints - 1.0)));
  }
  const auto stiffness = [](const LumpedCoupling& lumped) {
    return lumped.stiffness;
  };
  std::vector<MapLine> lines;
  if (IsFree(like)) {
    lines.push_back(Line(MapLineKind::kBoundary, "exact boundary", like, body, delays,
                         [](const LumpedCoupling& lumped) {
                           return CriticalStiffness(lumped);
                         }));
  }
  lines.push_back(Line(MapLineKind::kPassive, "passive: b / delay", like, body, delays,
                       [](const LumpedCoupling& lumped) {
                         return PassiveStiffness(lumped.delay_s, lumped.damping);
                       }));
  if (IsFree(like)) {
    lines.push_back(Line(MapLineKind::kAnyDelay, "stable at any delay", like, body, delays,
                         [](const LumpedCoupling& lumped) {
                           return AnyDelayStiffness(lumped.damping, lumped.mass,
                                                    lumped.relative_damping);
                         }));
  }
  const double calm = CouplingLimits{}.linear_stiffness;
  // constant gains have no stiffness of their own by delay: the default law's beside them
  const bool constant = like.law.name == "constant";
  LabCase of_law = WithLaw(like, DefaultLaw()->name(), calm);
  if (!constant) {
    of_law = like;
    of_law.law.ratio = 1;
    of_law.law.exchange_forces = false;
  }
  lines.push_back(Line(MapLineKind::kLaw,
                       (constant ? "default law: " : "law of these runs: ") + of_law.law.name,
                       of_law, body, delays, stiffness));
  lines.push_back(Line(MapLineKind::kLinearCalm,
                       "paper's linear law, " + ShortNumber(calm) + " N/m",
                       WithLaw(like, "linear", calm), body, delays, stiffness));
  lines.push_back(Line(MapLineKind::kLinearFirm,
                       "paper's linear law, " + ShortNumber(kFirmLinear) + " N/m",
                       WithLaw(like, "linear", kFirmLinear), body, delays, stiffness));
  return lines;
}

std::vector<StabilityMap> MapsOf(const Results& results, const BodyOf& body_of) {
  std::map<std::string, Group> groups;
  for (const auto& numbered : results.records) {
    const CellRecord& record = numbered.second;
    if (record.outcome.result.fault) continue;
    const CellFacts facts = FactsOf(record);
    const MapCell cell = CellOf(record, facts);
    if (!(cell.stiffness > 0) || !(cell.delay_s > 0)) continue;
    Group& group = groups[facts.map];
    if (group.first == nullptr) {
      group.first = &record;
      group.facts = facts;
    }
    const std::size_t place =
        group.places.try_emplace(facts.but_seed, group.cells.size()).first->second;
    if (place == group.cells.size()) group.cells.emplace_back();
    group.cells[place].Add(cell);
    ++group.runs;
  }
  std::vector<StabilityMap> maps;
  for (auto& keyed : groups) {
    Group& group = keyed.second;
    const Result<LabCase> parsed = ParseCase(group.first->cell.case_json, "cell");
    StabilityMap map;
    for (const Repeated& cell : group.cells) map.cells.push_back(cell.Shown());
    if (!MakesAMap(map.cells) || !parsed) continue;
    const CellFacts& facts = group.facts;
    map.title = "Stability by delay and stiffness: " + facts.scene + ", " +
                std::to_string(facts.users) + " users, hands " + facts.hands + ", network " +
                facts.network;
    map.note = LawOnMap(parsed->law) + (facts.gate ? ", gated" : ", no gate") + "; network " +
               facts.network_detail + ", states at " + TableNumber(facts.publish_hz) +
               " Hz; motion " + facts.motion + "; " + std::to_string(group.runs) + " runs";
    if (const std::optional<Inertia> body = body_of(*parsed)) {
      const MapRange range = RangeOf(map);
      map.lines = LinesOf(FittedTo(*body, *parsed), *body, range.shortest, range.longest);
    }
    maps.push_back(std::move(map));
  }
  std::ranges::stable_sort(maps, [](const StabilityMap& a, const StabilityMap& b) {
    return a.cells.size() > b.cells.size();
  });
  for (std::size_t i = 0; i < maps.size(); ++i) maps[i].name = "map-" + std::to_string(i + 1);
  return maps;
}

}  // namespace tandem
