#include "collab/lab/sweep/random_verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "collab/lab/case/case_parts.h"
#include "engine/base/hash.h"
#include "engine/base/text/hex.h"

namespace tandem {

namespace {

constexpr double kLongest = 300;    // s
constexpr double kModeTimes = 10;   // time constants; a motion of 5 m/s falls to 0.2 mm/s
constexpr double kAtRest = 0.2;     // share of the tail allowed, at which a run may end
constexpr std::size_t kWorst = 20;  // number of failing cases that the summary names

/// Returns the time that the slowest mode needs, s.
double TimeFor(const LabCase& test, const LabScene& scene) {
  const std::optional<GraspCoupling> coupling = GraspCouplingOf(test, scene.inertia());
  const std::optional<double> decay = coupling ? SlowestDecay(*coupling) : std::nullopt;
  if (!decay) return kLongest;
  return std::min(LastInputEnds(test) + kModeTimes / *decay, kLongest);
}

double Finite(double value) {
  return std::isfinite(value) ? value : std::numeric_limits<double>::infinity();
}

}  // namespace

CellOutcome RunRandomCase(const LabCase& test, const LabScene& scene) {
  CellOutcome outcome;
  outcome.predicted = Predict(test, scene.inertia());
  outcome.result = RunCase(test, scene, {},
                           {.most_s = TimeFor(test, scene), .rest_m_s = kAtRest * kMostRandomTail});
  return outcome;
}

double TailWithoutLinks(const LabCase& test, const LabScene& scene) {
  LabCase cut = test;
  cut.law = {.name = "constant", .limits = {.constant_stiffness = 0, .constant_damping = 0}};
  return RunRandomCase(cut, scene).result.metrics.tail_rms;
}

void RandomJudge::See(const SweepCell& cell, const CellOutcome& outcome) {
  RandomRecord record{first_ + cell.number, cell.case_json, outcome, {}};
  const CaseResult& result = outcome.result;
  if (result.fault) record.reasons.push_back(result.fault->what);
  if (result.verdict != Verdict::kStable) record.reasons.push_back(NameOf(result.verdict));
  if (!(result.metrics.generated_J <= kMostRandomEnergy)) {
    record.reasons.emplace_back("generates energy");
  }
  if (!(result.metrics.tail_rms < kMostRandomTail)) record.reasons.emplace_back("moves on");
  records_.push_back(std::move(record));
}

RandomSummary RandomJudge::Finish() const {
  RandomSummary summary;
  std::vector<const RandomRecord*> order;
  for (const RandomRecord& record : records_) order.push_back(&record);
  std::ranges::sort(order, {}, &RandomRecord::seed);
  Hash64 hash;
  for (const RandomRecord* record : order) {
    const CaseResult& result = record->outcome.result;
    const bool stable = !result.fault && result.verdict == Verdict::kStable;
    ++summary.cells;
    summary.not_stable += stable ? 0U : 1U;
    summary.failing += record->reasons.empty() ? 0U : 1U;
    if (record->outcome.predicted && record->outcome.predicted->is_stable()) {
      ++summary.predicted_stable;
      summary.predicted_stable_measured_unstable += result.verdict == Verdict::kUnstable ? 1U : 0U;
    }
    summary.max_energy_mJ =
        std::max(summary.max_energy_mJ, 1e3 * Finite(result.metrics.generated_J));
    summary.max_tail_rms_mm_s =
        std::max(summary.max_tail_rms_mm_s, 1e3 * Finite(result.metrics.tail_rms));
    summary.simulated_s += result.simulated_s;
    summary.cpu_s += record->outcome.cpu_s;
    hash.Add(result.digest);
  }
  summary.digest = Hex(hash.value());
  std::ranges::stable_sort(order, [](const RandomRecord* a, const RandomRecord* b) {
    return std::pair(a->reasons.size(), Finite(a->outcome.result.metrics.tail_rms)) >
           std::pair(b->reasons.size(), Finite(b->outcome.result.metrics.tail_rms));
  });
  for (const RandomRecord* record : order) {
    if (record->reasons.empty() || summary.worst.size() == kWorst) break;
    summary.worst.push_back(*record);
  }
  return summary;
}

}  // namespace tandem
