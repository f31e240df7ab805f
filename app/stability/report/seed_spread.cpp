#include "app/stability/report/seed_spread.h"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "app/stability/report/cell_facts.h"

namespace tandem {

namespace {

struct Case {
  CellFacts facts;
  std::vector<std::size_t> cells;
  std::vector<double> growths;  // 1/s
  std::vector<double> aparts;   // mm
  double tail_mm_s = 0;
  double force_N = 0;
  int stable = 0;
  int unstable = 0;
};

/// Returns the least, the median and the greatest.
std::vector<std::string> Spread(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t middle = values.size() / 2;
  const double median =
      values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
  return {TableNumber(values.front()), TableNumber(median), TableNumber(values.back())};
}

void Append(const std::vector<std::string>& more, std::vector<std::string>& row) {
  row.insert(row.end(), more.begin(), more.end());
}

bool SameFigures(const CellRecord& a, const CellRecord& b) {
  const auto figures = [](const CellRecord& record) {
    const Metrics& metrics = record.outcome.result.metrics;
    return std::array{metrics.growth, metrics.tail_rms, metrics.peak_apart, metrics.peak_force,
                      metrics.generated_J};
  };
  return figures(a) == figures(b);
}

}  // namespace

std::optional<ReportTable> SeedSpreadOf(const Results& results) {
  std::map<std::string, Case> cases;
  for (const auto& [number, record] : results.records) {
    const CaseResult& result = record.outcome.result;
    if (result.fault) continue;
    CellFacts facts = FactsOf(record);
    Case& one = cases[facts.but_seed];
    one.facts = std::move(facts);
    one.cells.push_back(number);
    one.growths.push_back(result.metrics.growth);
    one.aparts.push_back(1e3 * result.metrics.peak_apart);
    one.tail_mm_s = std::max(one.tail_mm_s, 1e3 * result.metrics.tail_rms);
    one.force_N = std::max(one.force_N, result.metrics.peak_force);
    one.stable += result.verdict == Verdict::kStable ? 1 : 0;
    one.unstable += result.verdict == Verdict::kUnstable ? 1 : 0;
  }
  std::erase_if(cases, [](const auto& one) {
    return one.second.cells.size() < 2;
  });
  if (cases.empty()) return std::nullopt;
  std::vector<const Case*> order;
  for (const auto& one : cases) order.push_back(&one.second);
  std::ranges::sort(order, {}, [](const Case* one) {
    return one->cells.front();
  });
  ReportTable table{"Spread over seeds of " + results.header.sweep,
                    "Each row is a case that ran with several seeds.",
                    {"first cell",
                     "scene",
                     "users",
                     "hands",
                     "delay, ms",
                     "network",
                     "states, Hz",
                     "law",
                     "motion",
                     "runs",
                     "stable",
                     "unstable",
                     "undecided",
                     "least growth, 1/s",
                     "median growth, 1/s",
                     "greatest growth, 1/s",
                     "greatest tail, mm/s",
                     "least apart, mm",
                     "median apart, mm",
                     "greatest apart, mm",
                     "greatest hand's force, N"},
                    {}};
  for (const Case* const one : order) {
    const CellFacts& facts = one->facts;
    const auto runs = static_cast<int>(one->cells.size());
    std::vector<std::string>& row = table.rows.emplace_back();
    row = {std::to_string(one->cells.front()),
           facts.scene,
           std::to_string(facts.users),
           facts.hands,
           TableNumber(1e3 * facts.delay_s),
           facts.network,
           TableNumber(facts.publish_hz),
           facts.law,
           facts.motion,
           std::to_string(runs),
           std::to_string(one->stable),
           std::to_string(one->unstable),
           std::to_string(runs - one->stable - one->unstable)};
    Append(Spread(one->growths), row);
    row.push_back(TableNumber(one->tail_mm_s));
    Append(Spread(one->aparts), row);
    row.push_back(TableNumber(one->force_N));
  }
  return table;
}

std::size_t CountCasesAlikeForAllSeeds(const Results& results) {
  struct Runs {
    const CellRecord* first = nullptr;
    std::size_t count = 0;
    bool alike = true;
  };
  std::map<std::string, Runs> cases;
  for (const auto& [number, record] : results.records) {
    if (record.outcome.result.fault) continue;
    const CellFacts facts = FactsOf(record);
    if (facts.network != "clean") continue;
    Runs& runs = cases[facts.but_seed];
    if (runs.first == nullptr) runs.first = &record;
    ++runs.count;
    runs.alike = runs.alike && SameFigures(*runs.first, record);
  }
  return static_cast<std::size_t>(std::ranges::count_if(cases, [](const auto& one) {
    return one.second.count > 1 && one.second.alike;
  }));
}

}  // namespace tandem
