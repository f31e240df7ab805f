#pragma once

#include <filesystem>
#include <string>

namespace tandem {

/// Why a file that is to be written at a run's end could not be, in one line; empty: it can. Asked
/// at the start, for then it is early enough. Leaves all files as they are.
std::string WhyNotWritable(const std::filesystem::path& file);

}  // namespace tandem
