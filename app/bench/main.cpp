#include <optional>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "app/bench/bench_commands.h"
#include "app/common/command_reference.h"
#include "app/common/console.h"
#include "app/common/end_of_output.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/stop_signal.h"
#include "engine/geometry/import/mesh_file.h"

namespace tandem {
namespace {

/// Writes the page of `tandem bench` with all that is below it, and the completion of tandem-bench,
/// which the completion of `tandem bench` reads.
int WriteBenchReference(CLI::App& tandem, const char* folder) {
  CLI::App program{tandem.get_subcommand("bench")->get_description()};
  program.name("tandem-bench");
  int unused = kExitOk;
  AddBenches(program, unused);
  const std::string fault = WriteReference({ManPages(tandem).at(1)}, program, folder);
  return fault.empty() ? kExitOk : Fail(kExitFile, fault);
}

}  // namespace
}  // namespace tandem

/// `tandem bench WORDS...` starts this program with these words. It reads them as words of `tandem
/// bench`, so that help and refusals name what the user has typed.
int main(int argc, char** argv) {
  tandem::RunImportHelperIfAsked(argc, argv);
  tandem::HandleSignals();
  CLI::App app{"Tandem: several people at several sites, one digital mock-up in all their hands"};
  app.name("tandem");
  app.set_version_flag("--version", TANDEM_VERSION);
  int exit_code = tandem::kExitOk;
  tandem::AddWholeBench(app, exit_code);
  if (argc == 3 && std::string_view(argv[1]) == "--write-reference") {
    return tandem::WriteBenchReference(app, argv[2]);
  }
  std::vector<const char*> words{"tandem", "bench"};
  words.insert(words.end(), argv + 1, argv + argc);
  const auto count = static_cast<int>(words.size());
  if (const std::optional<int> ended = tandem::ParseOrExplain(app, count, words.data())) {
    return tandem::EndOfOutput(*ended);
  }
  return tandem::EndOfOutput(exit_code);
}
