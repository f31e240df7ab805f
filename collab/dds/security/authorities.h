#pragma once

#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"

namespace tandem {

/// Returns why the two authorities are not separate, or true. Neither may have issued the other.
/// Otherwise every certificate of a member leads to both, and a member could sign permissions for
/// itself.
Result<bool> AreSeparate(const std::filesystem::path& identity_ca,
                         const std::filesystem::path& permissions_ca);

/// The times between which keys are valid.
struct KeyTimes {
  std::time_t from = 0;
  std::time_t until = 0;
};

/// Returns when all of these certificates are valid.
Result<KeyTimes> SharedTimes(const std::vector<std::filesystem::path>& certificates);

/// Returns a time as people read it: "2026-11-22 19:04 UTC".
std::string DayAndTime(std::time_t time);

}  // namespace tandem
