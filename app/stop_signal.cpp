#include "app/cli/stop_signal.h"

#include <csignal>

namespace tandem {

namespace {

std::atomic<bool> stop_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free);  // a signal handler may write it

void AskToStop(int) {
  stop_asked.store(true);
}

}  // namespace

const std::atomic<bool>& StopOnSignals() {
  std::signal(SIGINT, AskToStop);
  std::signal(SIGTERM, AskToStop);
  return stop_asked;
}

}  // namespace tandem
