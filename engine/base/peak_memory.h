#pragma once

#include <cstddef>

#include <unistd.h>

namespace tandem {

/// Returns the default bound of the bytes for making voxels or distance fields: three quarters of
/// the machine's memory; 8 GiB where the system does not tell.
inline std::size_t PeakMemory() noexcept {
  const long pages = sysconf(_SC_PHYS_PAGES);
  const long page_bytes = sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page_bytes <= 0) return std::size_t{8} << 30U;
  return static_cast<std::size_t>(pages) / 4 * 3 * static_cast<std::size_t>(page_bytes);
}

}  // namespace tandem
