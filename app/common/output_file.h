#pragma once

#include <filesystem>
#include <string>

namespace tandem {

/// Returns in one line why a file cannot be written; empty: it can. A program asks at its start for
/// a file that it writes at its end. No file is changed.
std::string WhyNotWritable(const std::filesystem::path& file);

}  // namespace tandem
