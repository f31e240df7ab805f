#include "app/common/end_of_output.h"

#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>

#include <poll.h>
#include <unistd.h>

#include "app/common/console.h"
#include "app/common/exit_codes.h"

namespace tandem {

int EndOfOutput(int exit_code) {
  errno = 0;
  const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (written || exit_code != kExitOk) return exit_code;
  const std::string reason = errno == 0 ? "" : ": " + std::generic_category().message(errno);
  pollfd reader{STDOUT_FILENO, POLLOUT, 0};
  // a reader that closed the pipe has had enough and need not hear of it
  if (poll(&reader, 1, 0) == 1 && (reader.revents & (POLLERR | POLLHUP)) != 0) return kExitFile;
  return Fail(kExitFile, "stdout: the output could not be written completely" + reason);
}

}  // namespace tandem
