#pragma once

#include <cstdlib>
#include <filesystem>

namespace tandem::testing {

/// Keeps the writing of a test's programs out of a person's folders: lists are dropped, and
/// voxelized meshes lie beside the tests' programs.
inline void KeepOutOfPersonsFolders() {
  setenv("XDG_STATE_HOME", "/dev/null", 0);
  std::error_code unknown;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", unknown);
  const std::filesystem::path build = program.parent_path().parent_path();
  setenv("TANDEM_CACHE", unknown ? "" : (build / "test-cache").c_str(), 0);
}

}  // namespace tandem::testing
