#include "app/common/describe_signal.h"

#include <csignal>

namespace tandem {

std::string DescribeSignal(int signal) {
  switch (signal) {
    case SIGKILL:
      return "was killed, by somebody or because memory ran out";
    case SIGTERM:
    case SIGINT:
    case SIGHUP:
    case SIGQUIT:
      return "was told to end by another program";
    default:
      return "crashed (signal " + std::to_string(signal) + ")";
  }
}

}  // namespace tandem
