#include "app/stability/report/maps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "app/picture/chart.h"
#include "app/stability/report/cell_facts.h"
#include "collab/lab/case/case_file.h"
#include "collab/lab/case/case_parts.h"
#include "collab/lab/case/prediction.h"

namespace tandem {

namespace {

constexpr int kLinePoints = 96;
constexpr int kGraspPoints = 21;  // fewer, since six axes take longer than one
constexpr std::size_t kLeastCells = 6;
constexpr double kFirmLinear = 200;  // N/m; stiffness at which the paper's law fails

// returns the least value over the users; NaN: the case has no equation
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

/// A case at a place along a map's axis.
struct CaseAt {
  double x = 0;
  LabCase test;
};

template <class Value>
MapLine Line(MapLineKind kind, std::string name, const std::vector<CaseAt>& cases,
             const Inertia& body, Value value) {
  MapLine line{kind, std::move(name), {}};
  for (const CaseAt& at : cases) line.points.push_back({at.x, LeastOf(at.test, body, value)});
  return line;
}

/// Returns the exact boundary in all six axes.
MapLine BoundaryLine(const std::vector<CaseAt>& cases, const Inertia& body) {
  MapLine line{MapLineKind::kBoundary, "exact boundary", {}};
  for (const CaseAt& at : cases) {
    const std::optional<Prediction> predicted = Predict(at.test, body);
    line.points.push_back(
        {at.x, predicted ? predicted->critical : std::numeric_limits<double>::quiet_NaN()});
  }
  return line;
}

bool HasGrasps(const LabCase& test) {
  return test.scene == "off_centre" || std::ranges::any_of(test.hands, [](const LabHand& hand) {
           return hand.grasp_B && !hand.grasp_B->isZero();
         });
}

std::vector<CaseAt> AtDelays(const LabCase& like, double shortest_s, double longest_s) {
  const int points = HasGrasps(like) ? kGraspPoints : kLinePoints;
  std::vector<CaseAt> cases;
  for (int i = 0; i < points; ++i) {
    cases.push_back({shortest_s * std::pow(longest_s / shortest_s, i / (points - 1.0)), like});
    cases.back().test.delay_s = cases.back().x;
  }
  return cases;
}

/// Returns cases along the grasp axis. The hands' own grasps are scaled about the centre of mass,
/// so that the farthest is at x.
std::vector<CaseAt> AtGrasps(const LabCase& like, double farthest) {
  double most = 0;
  for (const LabHand& hand : like.hands)
    most = std::max(most, hand.grasp_B.value_or(Vec3::Zero()).norm());
  std::vector<CaseAt> cases;
  for (int i = 0; i < kGraspPoints; ++i) {
    cases.push_back({farthest * i / (kGraspPoints - 1.0), like});
    for (LabHand& hand : cases.back().test.hands) {
      if (hand.grasp_B) *hand.grasp_B *= cases.back().x / most;
    }
  }
  return cases;
}

// needs enough cells, several columns, and several stiffnesses in one of them
bool MakesAMap(const std::vector<MapCell>& cells) {
  std::map<double, std::set<double>> columns;
  bool several = false;
  for (const MapCell& cell : cells) {
    columns[cell.x].insert(cell.stiffness);
    several = several || columns[cell.x].size() > 1;
  }
  return cells.size() >= kLeastCells && columns.size() > 1 && several;
}

MapCell CellOf(const CellRecord& record, const CellFacts& facts, MapAxis axis) {
  const Metrics& metrics = record.outcome.result.metrics;
  MapCell cell;
  cell.x = axis == MapAxis::kDelay ? facts.delay_s : facts.grasp_m;
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

/// The runs of one case with several seeds, shown as one cell: the worst run.
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
  std::map<std::string, std::size_t> places;  // index in `cells` of each repeated case
  std::vector<Repeated> cells;
  std::size_t runs = 0;
};

/// Describes the law without the quantities that a map varies: its ratio and a constant stiffness.
std::string LawOnMap(const LabLaw& law) {
  const CouplingLimits usual;
  std::string text = law.name == "constant" ? "constant gains" : law.name;
  const auto add = [&](const char* name, double CouplingLimits::*limit, const char* unit) {
    if (law.limits.*limit == usual.*limit) return;
    text += std::string(", ") + name + " " + TableNumber(law.limits.*limit) + unit;
  };
  add("drag", &CouplingLimits::constant_damping, " N s/m");
  add("link drag", &CouplingLimits::constant_link_damping, " N s/m");
  add("damping budget", &CouplingLimits::damping_budget, " N s/m");
  add("stiffness without delay", &CouplingLimits::stiffness, " N/m");
  add("margin", &CouplingLimits::margin, "");
  add("k0", &CouplingLimits::linear_stiffness, " N/m");
  if (law.exchange_forces) text += ", forces exchanged";
  return text;
}

/// Adds to the titles of maps with equal titles the details that differ, or a number where the
/// details do not distinguish them.
void TellTitlesApart(std::vector<StabilityMap>& maps) {
  std::map<std::string, std::vector<StabilityMap*>> titles;
  for (StabilityMap& map : maps) titles[map.title].push_back(&map);
  for (const auto& [title, alike] : titles) {
    for (std::size_t i = 0; i < alike.front()->details.size(); ++i) {
      const std::string& first = alike.front()->details[i];
      const bool differs = std::ranges::any_of(alike, [&](const StabilityMap* map) {
        return map->details[i] != first;
      });
      if (!differs) continue;
      for (StabilityMap* const map : alike) map->title += ", " + map->details[i];
    }
  }
  std::map<std::string, int> seen;
  for (StabilityMap& map : maps) {
    const int number = ++seen[map.title];
    if (number > 1) map.title += ", map " + std::to_string(number);
  }
}

/// Returns the lines of theory and of the laws along `cases`.
std::vector<MapLine> LinesAlong(const std::vector<CaseAt>& cases, const Inertia& body) {
  const LabCase& like = cases.front().test;
  const auto with_law = [&cases](const auto& change) {
    std::vector<CaseAt> changed = cases;
    for (CaseAt& at : changed) at.test = change(at.test);
    return changed;
  };
  const auto stiffness = [](const LumpedCoupling& lumped) {
    return lumped.stiffness;
  };
  std::vector<MapLine> lines;
  if (like.IsFree()) lines.push_back(BoundaryLine(cases, body));
  lines.push_back(Line(MapLineKind::kPassive, "passive: b / delay", cases, body,
                       [](const LumpedCoupling& lumped) {
                         return PassiveStiffness(lumped.delay_s, lumped.damping);
                       }));
  if (like.IsFree() && !HasGrasps(cases.back().test)) {
    lines.push_back(Line(MapLineKind::kAnyDelay, "stable at any delay", cases, body,
                         [](const LumpedCoupling& lumped) {
                           return AnyDelayStiffness(lumped.damping, lumped.mass,
                                                    lumped.relative_damping);
                         }));
  }
  const double calm = CouplingLimits{}.linear_stiffness;
  // constant gains do not depend on delay: the default law's line is shown beside them
  const bool constant = like.law.name == "constant";
  const std::vector<CaseAt> of_law = with_law([&](LabCase test) {
    if (constant) return WithLaw(std::move(test), DefaultLaw()->name(), calm);
    test.law.ratio = 1;
    test.law.exchange_forces = false;
    return test;
  });
  lines.push_back(
      Line(MapLineKind::kLaw,
           (constant ? "default law: " : "law of these runs: ") + of_law.front().test.law.name,
           of_law, body, stiffness));
  for (const auto& [kind, firmness] : {std::pair(MapLineKind::kLinearCalm, calm),
                                       std::pair(MapLineKind::kLinearFirm, kFirmLinear)}) {
    const auto linear = with_law([value = firmness](LabCase test) {
      return WithLaw(std::move(test), "linear", value);
    });
    lines.push_back(Line(kind, "paper's linear law, " + ShortNumber(firmness) + " N/m", linear,
                         body, stiffness));
  }
  return lines;
}

/// Sorts the cells into groups, one for each map.
std::map<std::string, Group> GroupsOf(const Results& results, MapAxis axis) {
  std::map<std::string, Group> groups;
  for (const auto& numbered : results.records) {
    const CellRecord& record = numbered.second;
    if (record.outcome.result.fault) continue;
    const CellFacts facts = FactsOf(record);
    const MapCell cell = CellOf(record, facts, axis);
    if (!(cell.stiffness > 0) || !(facts.delay_s > 0)) continue;
    Group& group = groups[axis == MapAxis::kDelay ? facts.map : facts.grasp_map];
    if (group.first == nullptr || facts.grasp_m > group.facts.grasp_m) {
      group.first = &record;
      group.facts = facts;
    }
    const std::size_t place =
        group.places.try_emplace(facts.but_seed, group.cells.size()).first->second;
    if (place == group.cells.size()) group.cells.emplace_back();
    group.cells[place].Add(cell);
    ++group.runs;
  }
  return groups;
}

std::optional<StabilityMap> MapOf(const Group& group, MapAxis axis, const BodyOf& body_of) {
  const Result<LabCase> parsed = ParseCase(group.first->cell.case_json, "cell");
  StabilityMap map;
  map.axis = axis;
  for (const Repeated& cell : group.cells) map.cells.push_back(cell.Shown());
  if (!MakesAMap(map.cells) || !parsed) return std::nullopt;
  const CellFacts& facts = group.facts;
  const bool is_delay = axis == MapAxis::kDelay;
  map.title = "Stability by " + std::string(is_delay ? "delay" : "grasp") +
              " and stiffness: " + facts.scene + ", " + std::to_string(facts.users) +
              " users, hands " + (is_delay ? facts.hands : facts.hand_kinds) + ", " +
              (is_delay ? "" : TableNumber(1e3 * facts.delay_s) + " ms, ") + "network " +
              facts.network;
  map.details = {LawOnMap(parsed->law), facts.gate ? "gated" : "no gate",
                 "network " + facts.network_detail,
                 "states at " + TableNumber(facts.publish_hz) + " Hz", "motion " + facts.motion};
  map.note = map.details[0] + ", " + map.details[1] + "; " + map.details[2] + ", " +
             map.details[3] + "; " + map.details[4] + "; " + std::to_string(group.runs) + " runs";
  if (const std::optional<Inertia> body = body_of(*parsed)) {
    const MapRange range = RangeOf(map);
    const LabCase fitted = FittedTo(*body, *parsed);
    map.lines = is_delay ? LinesOf(fitted, *body, range.least_x, range.most_x)
                         : LinesAlong(AtGrasps(fitted, range.most_x), *body);
  }
  return map;
}

}  // namespace

std::vector<MapLine> LinesOf(const LabCase& like, const Inertia& body, double shortest_s,
                             double longest_s) {
  return LinesAlong(AtDelays(like, shortest_s, longest_s), body);
}

std::vector<StabilityMap> MapsOf(const Results& results, const BodyOf& body_of) {
  std::vector<StabilityMap> maps;
  for (const MapAxis axis : {MapAxis::kDelay, MapAxis::kGrasp}) {
    for (const auto& [key, group] : GroupsOf(results, axis)) {
      std::optional<StabilityMap> map = MapOf(group, axis, body_of);
      if (map) maps.push_back(*std::move(map));
    }
  }
  std::ranges::stable_sort(maps, [](const StabilityMap& a, const StabilityMap& b) {
    return a.cells.size() > b.cells.size();
  });
  TellTitlesApart(maps);
  for (std::size_t i = 0; i < maps.size(); ++i) maps[i].name = "map-" + std::to_string(i + 1);
  return maps;
}

}  // namespace tandem
