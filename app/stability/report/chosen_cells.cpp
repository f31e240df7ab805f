#include "app/stability/report/chosen_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "app/stability/report/cell_facts.h"
#include "collab/lab/sweep/sweep_summary.h"

namespace tandem {

namespace {

constexpr std::size_t kMostOfAKind = 3;
constexpr double kUsualDelay = 0.1;  // s; the cell that represents a scene is the nearest to this
                                     // delay

double OrWorst(double value) {
  return std::isnan(value) ? std::numeric_limits<double>::infinity() : value;
}

class Choice {
 public:
  explicit Choice(std::size_t most) : most_(most) {}

  void Add(const CellRecord* record, const std::string& why) {
    if (record == nullptr) return;
    const auto found = std::ranges::find(chosen_, record->cell.number, &ChosenCell::number);
    if (found != chosen_.end()) {
      found->why += "; " + why;
    } else if (chosen_.size() < most_) {
      chosen_.push_back({record->cell.number, why});
    }
  }
  std::vector<ChosenCell> Take() { return std::move(chosen_); }

 private:
  std::size_t most_;
  std::vector<ChosenCell> chosen_;
};

template <class Value>
const CellRecord* Greatest(const std::vector<const CellRecord*>& records, Value value) {
  const auto found = std::ranges::max_element(records, [&value](const auto* a, const auto* b) {
    return value(*a) < value(*b);
  });
  return found == records.end() ? nullptr : *found;
}

// the cell of that verdict whose stiffness is nearest to the boundary, on the verdict's side
const CellRecord* Nearest(const Results& results, bool stable) {
  const CellRecord* nearest = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& numbered : results.records) {
    const CellRecord& record = numbered.second;
    const Verdict wanted = stable ? Verdict::kStable : Verdict::kUnstable;
    if (!record.outcome.predicted || record.outcome.result.verdict != wanted) continue;
    const Prediction& predicted = *record.outcome.predicted;
    const double beyond = std::log(predicted.stiffness / predicted.critical);
    const double away = stable ? -beyond : beyond;
    if (!(away >= 0) || away >= least) continue;
    least = away;
    nearest = &record;
  }
  return nearest;
}

std::string Unexpected(const CellRecord& record) {
  const Verdict verdict = record.outcome.result.verdict;
  if (record.cell.expect == Expectation::kStable && verdict != Verdict::kStable) {
    return "expected stable, but " + std::string(NameOf(verdict));
  }
  if (record.cell.expect == Expectation::kUnstable && verdict != Verdict::kUnstable) {
    return "a control (expected unstable), but " + std::string(NameOf(verdict));
  }
  const bool predicted = record.outcome.predicted && record.outcome.predicted->is_stable();
  if (predicted && verdict != Verdict::kStable) {
    return "predicted stable, but " + std::string(NameOf(verdict));
  }
  return {};
}

}  // namespace

std::vector<ChosenCell> ChooseCells(const Results& results, std::size_t most) {
  Choice choice(most);
  std::vector<const CellRecord*> of_default_law;
  std::vector<const CellRecord*> controls;
  std::map<std::string, const CellRecord*> of_scene;
  std::size_t unexpected = 0;
  for (const auto& numbered : results.records) {
    const CellRecord& record = numbered.second;
    if (record.outcome.result.fault) continue;
    const std::string why = Unexpected(record);
    if (!why.empty() && unexpected++ < kMostOfAKind) choice.Add(&record, why);
    if (record.cell.expect == Expectation::kUnstable) controls.push_back(&record);
    if (!IsOfDefaultLaw(record)) continue;
    of_default_law.push_back(&record);
    const CellFacts facts = FactsOf(record);
    const CellRecord*& stands = of_scene[facts.scene];
    const auto away = [](const CellRecord& one) {
      return std::abs(std::log(std::max(1e-3, FactsOf(one).delay_s) / kUsualDelay));
    };
    if (stands == nullptr || away(record) < away(*stands)) stands = &record;
  }
  choice.Add(Greatest(of_default_law,
                      [](const CellRecord& record) {
                        return OrWorst(record.outcome.result.metrics.tail_rms);
                      }),
             "default law, worst tail");
  choice.Add(Greatest(of_default_law,
                      [](const CellRecord& record) {
                        return OrWorst(record.outcome.result.metrics.generated_J);
                      }),
             "default law, most energy generated");
  choice.Add(Greatest(of_default_law,
                      [](const CellRecord& record) {
                        return OrWorst(record.outcome.result.metrics.peak_apart);
                      }),
             "default law, farthest apart");
  for (std::size_t i = 0; i < std::min(controls.size(), kMostOfAKind); ++i) {
    choice.Add(controls[i], "a control, expected unstable");
  }
  for (const auto& scene : of_scene) choice.Add(scene.second, "one of scene " + scene.first);
  choice.Add(Nearest(results, true), "stable, nearest below the boundary");
  choice.Add(Nearest(results, false), "unstable, nearest above the boundary");
  return choice.Take();
}

}  // namespace tandem
