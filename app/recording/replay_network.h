#pragma once

#include <string>

namespace tandem {

/// Makes a trace of what was heard of a peer, for `tandem replay RECORDING --as-network FILE`. The
/// peer is `from`, or the only one that was heard if `from` is empty. Returns the exit code.
int RunAsNetwork(const std::string& recording, const std::string& file, const std::string& from,
                 bool json);

}  // namespace tandem
