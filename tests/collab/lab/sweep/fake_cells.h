#pragma once

#include <atomic>
#include <cmath>
#include <fstream>
#include <limits>
#include <random>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "collab/lab/sweep/results_file.h"
#include "engine/base/hash.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {

/// Returns a sweep of 2 x 3 x 2 cells.
inline Sweep SmallSweep(const ScratchFolder& folder, const std::string& seed = "7") {
  const auto file = folder.Write(
      "small.json", R"({"name": "small", "seed": )" + seed +
                        R"(, "blocks": [{"hands": ["off", "heavy"], "delay_s": [0.02, 0.1, 1.0],
                           "network": ["clean", "lossy"]}]})");
  return *LoadSweep(file, [](const std::string&, const std::string&) {
    return std::nullopt;
  });
}

/// Stands in for running a cell: the case alone decides the figures, but for the times.
inline CellOutcome FakeOutcome(const SweepCell& cell) {
  Hash64 hash;
  hash.AddBytes(cell.case_json.data(), cell.case_json.size());
  std::mt19937_64 random(hash.value());
  std::normal_distribution<double> normal;
  CellOutcome outcome;
  outcome.result.metrics.growth = -std::abs(normal(random));
  outcome.result.metrics.tail_rms = 1e-5 * std::abs(normal(random));
  outcome.result.metrics.generated_J = 1e-300 * std::abs(normal(random));
  outcome.result.metrics.settle_s = std::numeric_limits<double>::quiet_NaN();
  outcome.result.metrics.frames = 12000;
  outcome.result.verdict = Verdict::kStable;
  outcome.result.digest = random();
  outcome.result.simulated_s = 12.0 / 7.0;
  outcome.predicted = Prediction{normal(random) + 100, 200.0 / 3.0};
  static std::atomic<int> calls{0};
  outcome.wall_s = ++calls;
  outcome.cpu_s = 0.5 * outcome.wall_s;
  return outcome;
}

inline ResultsHeader HeaderFor(const Sweep& sweep, const Shard& shard = {}) {
  return {.sweep = sweep.name,
          .seed = sweep.seed,
          .sweep_hash = sweep.hash,
          .version = "1.2",
          .program = "0123456789abcdef",
          .cells = sweep.cells.size(),
          .shard = shard.Name(),
          .command = "tandem stability sweep small.json"};
}

/// Runs the cells that the log has not got yet, to the end.
inline void RunRest(const Sweep& sweep, const Shard& shard, const std::filesystem::path& file,
                    unsigned jobs, const CellRunner& run = FakeOutcome) {
  Result<ResultsLog> log = ResultsLog::Open(file, HeaderFor(sweep, shard));
  ASSERT_TRUE(log) << log.error().what;
  std::vector<SweepCell> rest;
  for (const SweepCell& cell : sweep.cells) {
    if (shard.Has(cell) && !log->Has(cell)) rest.push_back(cell);
  }
  RunCells(rest, jobs, run, [&](const SweepCell& cell, const CellOutcome& outcome) {
    EXPECT_FALSE(log->Add({cell, outcome}));
  });
  EXPECT_FALSE(log->Finish());
}

inline std::string ContentOf(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// Returns the content without the times that the cells took.
inline std::string Timeless(const std::string& content) {
  static const std::regex times(R"re("(wall|cpu)_s":[0-9.]+)re");
  return std::regex_replace(content, times, "");
}

}  // namespace tandem::testing
