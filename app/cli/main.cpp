#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "app/cli/commands.h"
#include "app/common/end_of_output.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/stop_signal.h"
#include "app/invite/given_line.h"
#include "engine/geometry/import/mesh_file.h"

int main(int argc, char** argv) {
  tandem::RunImportHelperIfAsked(argc, argv);
  const std::vector<std::string> words = tandem::TakeWords(argc, argv);
  std::vector<const char*> named;
  for (const std::string& word : words) named.push_back(word.c_str());
  tandem::HandleSignals();
  CLI::App app{"Tandem: several people at several sites, one digital mock-up in all their hands"};
  app.name("tandem");
  app.require_subcommand(1);
  app.set_version_flag("--version", TANDEM_VERSION);
  int exit_code = tandem::kExitOk;
  tandem::AddCommands(app, exit_code);
  if (const std::optional<int> ended = tandem::ParseOrExplain(app, argc, named.data())) {
    return tandem::EndOfOutput(*ended);
  }
  return tandem::EndOfOutput(exit_code);
}
