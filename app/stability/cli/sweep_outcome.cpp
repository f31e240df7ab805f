#include "app/stability/cli/sweep_outcome.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <vector>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/stability/report/seed_spread.h"
#include "engine/base/files/whole_file.h"
#include "engine/base/hash.h"
#include "engine/base/text/hex.h"

namespace tandem {

namespace {

constexpr std::size_t kMostTold = 10;  // cells that are told

void TellCell(const CellRecord& record) {
  const CaseResult& result = record.outcome.result;
  if (result.fault) {
    PrintLine("  cell %zu: %s", record.cell.number, result.fault->what.c_str());
  } else {
    PrintLine("  cell %zu: %s, growth %.3g 1/s, tail %.3g mm/s, energy %.3g mJ", record.cell.number,
              NameOf(result.verdict), result.metrics.growth, 1e3 * result.metrics.tail_rms,
              1e3 * result.metrics.generated_J);
  }
  PrintLine("    %s", record.cell.case_json.c_str());
}

}  // namespace

int TellOutcome(const Results& results, const SweepRun& run) {
  const SweepSummary summary = Summarize(results);
  const int exit_code = summary.pass() ? kExitOk : kExitFailed;
  if (const std::size_t alike = CountCasesAlikeForAllSeeds(results); alike > 0) {
    Say(std::to_string(alike) + (alike == 1 ? " case has" : " cases have") +
        " the same figures with all seeds, because nothing is random in a clean network at this "
        "rate: give it jitter or loss, or one seed");
  }
  if (run.json) {
    PrintText(JsonOf(summary, run.wall_s, run.jobs));
    return exit_code;
  }
  for (const SweepRow& row : summary.rows) {
    PrintLine("%s  %-45s %8.4g  %s", row.pass ? "pass" : "FAIL", row.name.c_str(), row.value,
              row.bar.c_str());
  }
  PrintLine(
      "%zu cells, %.0f s simulated in %.1f s with %u at a time (%.1f s of processor time), digest "
      "%s",
      summary.cells, summary.simulated_s, run.wall_s, run.jobs, summary.cpu_s,
      summary.digest.c_str());
  for (std::size_t i = 0; i < std::min(kMostTold, summary.failing.size()); ++i) {
    TellCell(results.records.at(summary.failing[i]));
  }
  if (summary.failing.size() > kMostTold) {
    PrintLine("  and %zu more", summary.failing.size() - kMostTold);
  }
  return exit_code;
}

std::optional<Error> WriteSummary(const std::filesystem::path& results_file, const Results& results,
                                  const SweepRun& run) {
  const std::filesystem::path file = results_file.parent_path() / "summary.json";
  return WriteWholeFile(file, JsonOf(Summarize(results), run.wall_s, run.jobs) + '\n');
}

std::string ProgramDigest() {
  std::ifstream program("/proc/self/exe", std::ios::binary);
  std::vector<char> block(1U << 20U);
  Hash64 hash;
  while (program) {
    program.read(block.data(), static_cast<std::streamsize>(block.size()));
    hash.AddBytes(block.data(), static_cast<std::size_t>(program.gcount()));
  }
  return Hex(hash.value());
}

}  // namespace tandem
