#include <cstdlib>
#include <memory>
#include <string>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/connection/connection_options.h"
#include "app/study/run/study_session.h"

namespace tandem {

namespace {

struct StudyArguments {
  StudyRequest request;
  ConnectionOptions connection;
  std::string site = "participant";
  std::string folder;
};

/// Returns the options of `tandem peer` that say the same.
std::vector<std::string> StudyReachWords(const ConnectionOptions& connection) {
  std::vector<std::string> words{"--domain", std::to_string(connection.domain)};
  const auto add = [&words](const char* option, const std::string& value) {
    if (value.empty()) return;
    words.emplace_back(option);
    words.push_back(value);
  };
  std::string peers;
  for (const std::string& peer : connection.peers) peers += (peers.empty() ? "" : ",") + peer;
  add("--interface", connection.interface);
  add("--peers", peers);
  add("--external-address", connection.external_address);
  add("--port", connection.port == 0 ? "" : std::to_string(connection.port));
  add("--secure", connection.secure);
  return words;
}

bool DisplayIsSet() {
  const auto set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0';
  };
  return set("DISPLAY") || set("WAYLAND_DISPLAY");
}

int RunStudyCommand(StudyArguments& arguments) {
  StudyRequest& request = arguments.request;
  request.folder =
      arguments.folder.empty() ? request.file.stem().string() + "-results" : arguments.folder;
  request.version = TANDEM_VERSION;
  request.partner_site = arguments.site == "partner";
  request.connection = StudyReachWords(arguments.connection);
  const bool runs = !request.results_only && request.withdraw.empty();
  if (runs && !request.dry_run && request.device.empty() && !DisplayIsSet()) {
    return Fail(kExitDisplay,
                "the participant's window needs a display, and there is none: give --device "
                "NAME:OPTIONS ('tandem devices' lists them), or --dry-run for modelled hands");
  }
  return RunStudy(request);
}

}  // namespace

void AddStudyCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<StudyArguments>();
  StudyRequest& request = arguments->request;
  CLI::App* command = app.add_subcommand(
      "study", "Run delay experiments with persons: blind trials, questions, results");
  command->add_option("STUDY", request.file, "study file (JSON, docs/studies.md)")->required();
  command->add_option(
      "--into", arguments->folder,
      "folder for log, trials and results; default: the study's name with -results");
  command->add_option("--participant", request.participant,
                      "pseudonym of the participant; default: the next in turn");
  command->add_option("--device", request.device,
                      "device of the person here, NAME[:OPTIONS] of 'tandem devices'; default: the "
                      "mouse, in a window");
  CLI::Option* dry = command->add_flag(
      "--dry-run", request.dry_run, "replace all participants by modelled hands, in virtual time");
  command
      ->add_flag("--real-time", request.real_time,
                 "with --dry-run: run real peers over DDS, in real time")
      ->needs(dry);
  command
      ->add_option("--site", arguments->site,
                   "site of this run if the partner is a person: participant or partner")
      ->check(OneOf({"participant", "partner"}))
      ->capture_default_str();
  command
      ->add_option("--from-trial", request.from_trial,
                   "number of the first trial to run, if the other site is already there")
      ->check(WholeNumberFrom(1, 10'000))
      ->capture_default_str();
  command
      ->add_option("--wait-seconds", request.wait_seconds,
                   "longest wait for the partner in each trial, s")
      ->check(NumberFrom(0, kLongestRun))
      ->capture_default_str();
  command->add_option("--withdraw", request.withdraw,
                      "remove all data of this pseudonym, then write the results");
  command->add_flag("--results", request.results_only, "run no trial: write the results again");
  command->add_flag("--json", request.json, "print one JSON object");
  AddConnectionOptions(*command, arguments->connection);
  command->callback([arguments, &exit_code] {
    exit_code = RunStudyCommand(*arguments);
  });
}

}  // namespace tandem
