#pragma once

#include <filesystem>
#include <optional>

namespace tandem {

/// Reads the command line of a generator, which is one folder that exists. Without a value it has
/// printed its usage or a fault, and the program ends with `exit_code`.
std::optional<std::filesystem::path> FolderToFill(int argc, const char* const* argv,
                                                  const char* program, const char* what,
                                                  int& exit_code);

}  // namespace tandem
