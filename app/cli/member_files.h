#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds to `tandem keys` the way by files, for where no line leads to the inviter: `request`,
/// `answer` and `take`.
void AddMemberFileCommands(CLI::App& keys, int& exit_code);

}  // namespace tandem
