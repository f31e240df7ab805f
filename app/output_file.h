#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/base/result.h"

namespace tandem {

/// Why a file that is to be written at a run's end could not be, in one line; empty: it can. Asked
/// at the start, for then it is early enough. Leaves all files as they are.
std::string WhyNotWritable(const std::filesystem::path& file);

/// Writes the whole file, or leaves the one that was there: the text goes to a new file beside it,
/// reaches the disk, and takes its name. What is no regular file (a pipe, /dev/stdout) is written
/// straight away.
Result<bool> WriteWhole(const std::filesystem::path& file, std::string_view text);

}  // namespace tandem
