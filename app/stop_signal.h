#pragma once

#include <atomic>

namespace tandem {

/// Makes SIGINT and SIGTERM set the flag that is returned, in place of ending the process.
const std::atomic<bool>& StopOnSignals();

}  // namespace tandem
