#pragma once

#include <filesystem>

namespace tandem {

/// Takes from this process, for good, what reading one mesh file does not need, as far as the
/// kernel can: it reads the file and what lies in its folder and below, and writes to what is open
/// already; no other file, no network, no other program, no signal to another process. What it then
/// tries fails with EPERM or EACCES. Does nothing under a sanitizer, which has needs of its own.
void ConfineToFile(const std::filesystem::path& file);

}  // namespace tandem
