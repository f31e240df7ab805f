#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/soak/soak_program.h"

namespace tandem::testing {

/// Bounds of the endurance run for each life of a program.
struct SoakBounds {
  double settle_s = 300;          // time from a program's start until its memory must be flat
  std::int64_t growth = 4 << 20;  // bytes that a program may grow by afterwards
  std::size_t files = 8;          // descriptors that it may have more of afterwards
  double end_s = 1;               // from SIGTERM to the end
  double lines_per_s = 11;        // ten, and one more where a window begins within a second
  double least_delay_ms = 50;     // each way, as a peer measures it
  double contact_after_s = 20;    // time of a life from which on there has been contact
};

/// The course of a life's memory after it had settled.
struct MemoryTrend {
  static constexpr double kWindow = 10;  // s, over which a mean is taken

  double judged_s = 0;       // from the settled window's begin to the end
  std::int64_t settled = 0;  // bytes, mean of the first window
  std::int64_t last = 0;     // bytes, mean of the last window
  std::int64_t most = 0;     // bytes
  std::size_t settled_files = 0;
  std::size_t last_files = 0;

  std::int64_t growth() const { return last - settled; }
};
/// Returns the course of a life's memory; nothing: the life was too short to judge it.
std::optional<MemoryTrend> TrendOf(const SoakLife& life, double settle_s);

/// Returns the places in a report whose number is none: JSON has null there. Places that a peer
/// without a device process leaves empty are sound.
std::vector<std::string> EmptyNumbers(const nlohmann::json& report);

/// Reads a life's report and its trace, and returns what was wrong, in words; empty: nothing.
std::vector<std::string> FaultsOf(const SoakLife& life, const SoakBounds& bounds);

/// Returns a life's figures; for a peer that was not killed also those of its report.
nlohmann::ordered_json AsJson(const SoakLife& life, const SoakBounds& bounds);

}  // namespace tandem::testing
