#pragma once

#include <string>

namespace tandem {

/// `tandem replay RECORDING --as-network FILE`: makes a trace of what was heard of the peer `from`,
/// or, where `from` is empty, of the only one that was heard. Returns the exit code.
int RunAsNetwork(const std::string& recording, const std::string& file, const std::string& from,
                 bool json);

}  // namespace tandem
