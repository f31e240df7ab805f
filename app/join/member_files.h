#pragma once

#include <CLI/CLI.hpp>

namespace tandem {

/// Adds `request`, `answer` and `take` to `tandem keys`. They enrol a member by files, where no
/// line leads to the inviter.
void AddMemberFileCommands(CLI::App& keys, int& exit_code);

}  // namespace tandem
