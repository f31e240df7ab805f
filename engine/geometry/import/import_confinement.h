#pragma once

#include <filesystem>

namespace tandem {

/// Takes from this process, for good, what reading one mesh file does not need, as far as the
/// kernel can. The process can read the file and the contents of its folder and below, and write to
/// open descriptors. It has no other file, network, other program or signal to another process.
/// A process that tries gets EPERM or EACCES. The function does nothing under a
/// sanitizer, which needs more.
void ConfineToFile(const std::filesystem::path& file);

}  // namespace tandem
