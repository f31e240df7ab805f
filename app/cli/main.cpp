#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>

#include <CLI/CLI.hpp>
#include <poll.h>
#include <unistd.h>

#include "app/cli/commands.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/stop_signal.h"
#include "app/common/talk.h"
#include "engine/geometry/import/mesh_file.h"

namespace tandem {
namespace {

/// Returns the exit code once all output is written. A script must not take part of a result for
/// the whole.
int EndOfOutput(int exit_code) {
  errno = 0;
  const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (written || exit_code != kExitOk) return exit_code;
  const std::string reason = errno == 0 ? "" : ": " + std::generic_category().message(errno);
  pollfd reader{STDOUT_FILENO, POLLOUT, 0};
  // a reader that closed the pipe has had enough and need not hear of it
  if (poll(&reader, 1, 0) == 1 && (reader.revents & (POLLERR | POLLHUP)) != 0) return kExitFile;
  return Fail(kExitFile, "stdout: not all could be written" + reason);
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  tandem::RunImportHelperIfAsked(argc, argv);
  tandem::HandleSignals();
  CLI::App app{"Tandem: several people at several sites, one digital mock-up in all their hands"};
  app.name("tandem");
  app.require_subcommand(1);
  app.set_version_flag("--version", TANDEM_VERSION);
  int exit_code = tandem::kExitOk;
  tandem::AddCommands(app, exit_code);
  if (const std::optional<int> ended = tandem::ParseOrExplain(app, argc, argv)) {
    return tandem::EndOfOutput(*ended);
  }
  return tandem::EndOfOutput(exit_code);
}
