#include <cstdio>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/recording/trace_facts.h"
#include "app/stability/cli/stability_command.h"
#include "collab/trace/trace_file.h"
#include "collab/trace/trace_models.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

struct TraceArguments {
  std::string name;
  std::string out;
  TraceLength length;
  bool json = false;
};

int RunStabilityTrace(const TraceArguments& arguments) {
  const Result<NetworkTrace> trace = MakeTrace(arguments.name, arguments.length);
  if (!trace) return Fail(kExitUsage, trace.error().what);
  if (const auto failed = WriteNetworkTrace(arguments.out, *trace)) {
    return Fail(kExitFile, failed->what);
  }
  if (arguments.json) {
    PrintText(JsonText(FactsAsJson(*trace), 2));
  } else {
    PrintText(FactsAsText(*trace));
  }
  return kExitOk;
}

}  // namespace

void AddStabilityTrace(CLI::App& stability, int& exit_code) {
  auto arguments = std::make_shared<TraceArguments>();
  CLI::App* command =
      stability.add_subcommand("trace", "Make a network trace from a model, for plans and cases");
  std::string names;
  for (const TraceModel& model : TraceModels()) names += (names.empty() ? "" : ", ") + model.name;
  command->add_option("model", arguments->name, "model of a network, one of " + names)->required();
  command->add_option("--out", arguments->out, "trace file to write (CSV)")
      ->required()
      ->check(FileEndingIn({".csv"}));
  command->add_option("--seconds", arguments->length.seconds, "length, s")
      ->capture_default_str()
      ->check(NumberAbove(0, 3600));
  command->add_option("--rate", arguments->length.rate_hz, "samples each way, Hz")
      ->capture_default_str()
      ->check(NumberFrom(1, kMostTraceHz));
  command->add_option("--seed", arguments->length.seed, "random seed")
      ->capture_default_str()
      ->check(WholeNumberFrom(0, kLargestSeed));
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = RunStabilityTrace(*arguments);
  });
}

}  // namespace tandem
