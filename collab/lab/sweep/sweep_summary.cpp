#include "collab/lab/sweep/sweep_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

#include "collab/coupling/coupling_law.h"

namespace tandem {

namespace {

constexpr double kMostEnergy_mJ = 1;
constexpr double kMostTail_mm_s = 2;

// treats infinities and NaN as the worst value
double Worse(double worst, double value) {
  return std::isfinite(value) ? std::max(worst, value) : std::numeric_limits<double>::infinity();
}

bool IsDefaultLaw(const nlohmann::json& test) {
  const nlohmann::json& law = test["law"];
  return law["name"] == DefaultLaw()->name() && law["ratio"] == 1 && !law.contains("limits") &&
         !law.contains("boundary_ratio") && !law.contains("exchange_forces");
}

class Count {
 public:
  void Add(const CellRecord& record) {
    const CaseResult& result = record.outcome.result;
    const nlohmann::json test = nlohmann::json::parse(record.cell.case_json);
    const bool stable = !result.fault && result.verdict == Verdict::kStable;
    const bool unstable = !result.fault && result.verdict == Verdict::kUnstable;
    const bool undecided = !result.fault && result.verdict == Verdict::kUndecided;
    ++summary_.cells;
    summary_.simulated_s += result.simulated_s;
    summary_.cpu_s += record.outcome.cpu_s;
    summary_.wall_s += record.outcome.wall_s;
    // count what a row counts; a wrong cell fails by that row
    bool fails = false;
    const auto count = [&fails](bool wrong, std::size_t& number) {
      number += wrong ? 1U : 0U;
      fails = fails || wrong;
    };
    count(result.fault.has_value(), faults_);
    count(result.metrics.trapped_frames > 0, trapped_);
    summary_.undecided += undecided ? 1U : 0U;
    if (record.outcome.predicted && record.outcome.predicted->is_stable()) {
      ++summary_.predicted_stable;
      count(unstable, summary_.predicted_stable_measured_unstable);
      count(undecided, summary_.predicted_stable_undecided);
    }
    if (record.cell.expect == Expectation::kUnstable) {
      ++summary_.positive_controls;
      summary_.positive_controls_caught += unstable ? 1U : 0U;
      fails = fails || !unstable;
    }
    if (record.cell.expect == Expectation::kStable) {
      ++expected_;
      count(!stable, not_as_expected_);
    }
    if (IsDefaultLaw(test)) {
      const double energy_mJ = 1e3 * result.metrics.generated_J;
      const double tail_mm_s = 1e3 * result.metrics.tail_rms;
      ++summary_.default_law_cells;
      count(!stable, summary_.default_law_unstable);
      fails = fails || !(energy_mJ <= kMostEnergy_mJ) || !(tail_mm_s < kMostTail_mm_s);
      summary_.max_energy_mJ = Worse(summary_.max_energy_mJ, energy_mJ);
      summary_.max_tail_rms_mm_s = Worse(summary_.max_tail_rms_mm_s, tail_mm_s);
    }
    if (fails) summary_.failing.push_back(record.cell.number);
    if (test["scene"] == "free" && test["users"] == 2 && !result.metrics.diverged) {
      pair_s_ += result.simulated_s;
      pair_cpu_s_ += record.outcome.cpu_s;
    }
  }

  SweepSummary Finish() {
    SweepSummary& s = summary_;
    if (pair_cpu_s_ > 0) s.free_pair_speed = pair_s_ / pair_cpu_s_;
    None("cells that could not be run", faults_);
    None("cells with a wall between the instances", trapped_);
    if (s.predicted_stable > 0) {
      None("predicted stable, measured unstable", s.predicted_stable_measured_unstable);
      None("predicted stable, undecided in its time", s.predicted_stable_undecided);
    }
    if (expected_ > 0) None("held to be stable, not measured so", not_as_expected_);
    if (s.default_law_cells > 0) {
      None("default law, not stable", s.default_law_unstable);
      Row("default law, generated energy, mJ", "<= 1", s.max_energy_mJ,
          s.max_energy_mJ <= kMostEnergy_mJ);
      Row("default law, tail RMS, mm/s", "< 2", s.max_tail_rms_mm_s,
          s.max_tail_rms_mm_s < kMostTail_mm_s);
    }
    if (s.positive_controls > 0) {
      Row("controls reported unstable", "= " + std::to_string(s.positive_controls),
          static_cast<double>(s.positive_controls_caught),
          s.positive_controls_caught == s.positive_controls);
    }
    return std::move(summary_);
  }

 private:
  void Row(std::string name, std::string bar, double value, bool pass) {
    summary_.rows.push_back({std::move(name), std::move(bar), value, pass});
  }
  void None(std::string name, std::size_t value) {
    Row(std::move(name), "= 0", static_cast<double>(value), value == 0);
  }

  SweepSummary summary_;
  std::size_t faults_ = 0;
  std::size_t trapped_ = 0;
  std::size_t expected_ = 0;
  std::size_t not_as_expected_ = 0;
  double pair_s_ = 0;
  double pair_cpu_s_ = 0;
};

}  // namespace

bool SweepSummary::pass() const {
  return std::ranges::all_of(rows, [](const SweepRow& row) {
    return row.pass;
  });
}

SweepSummary Summarize(const Results& results) {
  Count count;
  for (const auto& [number, record] : results.records) count.Add(record);
  SweepSummary summary = count.Finish();
  summary.digest = DigestOf(results);
  return summary;
}

bool IsOfDefaultLaw(const CellRecord& record) {
  return IsDefaultLaw(nlohmann::json::parse(record.cell.case_json));
}

std::string JsonOf(const SweepSummary& summary, double wall_s, unsigned jobs) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const SweepRow& row : summary.rows) {
    rows.push_back(
        {{"name", row.name}, {"bar", row.bar}, {"value", row.value}, {"pass", row.pass}});
  }
  return nlohmann::ordered_json{
      {"cells", summary.cells},
      {"wall_s", wall_s},
      {"jobs", jobs},
      {"digest", summary.digest},
      {"predicted_stable", summary.predicted_stable},
      {"predicted_stable_measured_unstable", summary.predicted_stable_measured_unstable},
      {"predicted_stable_undecided", summary.predicted_stable_undecided},
      {"undecided", summary.undecided},
      {"default_law_cells", summary.default_law_cells},
      {"default_law_unstable", summary.default_law_unstable},
      {"max_energy_mJ", summary.max_energy_mJ},
      {"max_tail_rms_mm_s", summary.max_tail_rms_mm_s},
      {"positive_controls", summary.positive_controls},
      {"positive_controls_caught", summary.positive_controls_caught},
      {"simulated_s", summary.simulated_s},
      {"cpu_s", summary.cpu_s},
      {"free_pair_speed", summary.free_pair_speed},
      {"rows", rows}}
      .dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace tandem
