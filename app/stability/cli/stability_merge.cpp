#include <filesystem>
#include <memory>
#include <vector>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/stability/cli/stability_command.h"
#include "app/stability/cli/sweep_outcome.h"

namespace tandem {

namespace {

struct MergeArguments {
  std::vector<std::string> files;
  std::string out;
  bool json = false;
};

int RunStabilityMerge(const MergeArguments& arguments) {
  std::vector<std::filesystem::path> files;
  for (const std::string& each : arguments.files) {
    const std::filesystem::path path = each;
    files.push_back(std::filesystem::is_directory(path) ? path / "cells.jsonl" : path);
  }
  const Result<Results> merged = Merge(files);
  if (!merged) return Fail(kExitFailed, merged.error().what);
  const SweepRun run{.wall_s = Summarize(*merged).wall_s, .jobs = 1, .json = arguments.json};
  if (!arguments.out.empty()) {
    std::error_code failed;
    std::filesystem::create_directories(arguments.out, failed);
    if (failed) return Fail(kExitFile, arguments.out + ": " + failed.message());
    const std::filesystem::path file = std::filesystem::path(arguments.out) / "cells.jsonl";
    std::optional<Error> wrong = WriteResults(file, *merged);
    if (!wrong) wrong = WriteSummary(file, *merged, run);
    if (wrong) return Fail(kExitFile, wrong->what);
  }
  return TellOutcome(*merged, run);
}

}  // namespace

void AddStabilityMerge(CLI::App& stability, int& exit_code) {
  auto arguments = std::make_shared<MergeArguments>();
  CLI::App* command =
      stability.add_subcommand("merge", "Merge the shards of a sweep as if it had run at once");
  command->add_option("files", arguments->files, "results files, or the folders that contain them")
      ->required();
  command->add_option("--out", arguments->out, "folder for cells.jsonl and summary.json");
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunStabilityMerge(*arguments);
  });
}

}  // namespace tandem
