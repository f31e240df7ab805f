#pragma once

#include <cmath>
#include <string>

#include "collab/lab/sweep/results_file.h"

namespace tandem::testing {

/// Makes a cell of constant gains in free space with heavy hands.
inline CellRecord MadeCell(std::size_t number, double delay_s, double stiffness, double critical) {
  CellRecord record;
  record.cell.number = number;
  record.cell.key = "00000000000000" + std::to_string(10 + number);
  record.cell.case_json =
      R"({"name":"c","scene":"free","users":2,"hands":["heavy"],"motion":"kick","law":)"
      R"({"name":"constant","ratio":1,"gate":false,"limits":{"constant_damping":10,)"
      R"("constant_stiffness":)" +
      std::to_string(stiffness) + R"(}},"delay_s":)" + std::to_string(delay_s) +
      R"(,"network":"clean","publish_hz":1000,"seconds":0,"seed":7})";
  CaseResult& result = record.outcome.result;
  const bool stable = stiffness < critical;
  result.verdict = stable ? Verdict::kStable : Verdict::kUnstable;
  result.metrics.growth = std::log(stiffness / critical);
  result.metrics.tail_rms = stable ? 1e-6 : 0.05;
  result.metrics.windows = 20;
  result.metrics.stiffness = stiffness;
  result.metrics.diverged = stiffness > 3 * critical;
  result.digest = 0xabc0 + number;
  result.simulated_s = 12;
  record.outcome.predicted = Prediction{stiffness, critical};
  record.outcome.cpu_s = 0.05;
  record.outcome.wall_s = 0.06;
  return record;
}

/// Makes the cells of four delays by five stiffnesses.
inline Results TwentyCells() {
  Results results;
  results.header = {"made",
                    3,
                    "0123456789abcdef",
                    "0.1",
                    "fedcba9876543210",
                    20,
                    "1/1",
                    "tandem stability sweep made.json"};
  std::size_t number = 0;
  for (const double delay_s : {0.02, 0.1, 0.3, 1.0}) {
    for (const double stiffness : {10.0, 30.0, 90.0, 270.0, 810.0}) {
      results.records.emplace(number, MadeCell(number, delay_s, stiffness, 30 + 12 / delay_s));
      ++number;
    }
  }
  return results;
}

/// Replaces text of a cell's case, which makes it one of the default law, or of another scene.
inline void ReplaceInCase(CellRecord& record, const std::string& what, const std::string& with) {
  std::string& text = record.cell.case_json;
  text.replace(text.find(what), what.size(), with);
}

}  // namespace tandem::testing
