#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/soak/soak_program.h"

namespace tandem::testing {

/// What the endurance run asks of each life of a program.
struct SoakBounds {
  double settle_s = 300;          // from a program's start, until its memory must be flat
  std::int64_t growth = 4 << 20;  // bytes that a program may grow by afterwards
  std::size_t files = 8;          // descriptors that it may have more of afterwards
  double end_s = 1;               // from SIGTERM to the end
  double lines_per_s = 11;        // ten, and one more where a window begins within a second
  double least_delay_ms = 50;     // each way, as a peer measures it
  double contact_after_s = 20;    // of a life, from which on there has been contact
};

/// How the memory of a life went after it had settled.
struct MemoryCourse {
  static constexpr double kWindow = 10;  // s, over which a mean is taken

  double judged_s = 0;       // from the settled window's begin to the end
  std::int64_t settled = 0;  // bytes, mean of the first window
  std::int64_t last = 0;     // bytes, mean of the last window
  std::int64_t most = 0;     // bytes
  std::size_t settled_files = 0;
  std::size_t last_files = 0;

  std::int64_t growth() const { return last - settled; }
};
/// Nothing: the life was too short to judge it.
std::optional<MemoryCourse> CourseOf(const SoakLife& life, double settle_s);

/// The places in a report whose number is none: JSON has null there. What a peer without a device
/// process leaves empty is sound.
std::vector<std::string> EmptyNumbers(const nlohmann::json& report);

/// What was wrong with a life, in words; empty: nothing. Reads its report and its trace.
std::vector<std::string> FaultsOf(const SoakLife& life, const SoakBounds& bounds);

/// A life's figures; of a peer that was not killed those of its report too.
nlohmann::ordered_json AsJson(const SoakLife& life, const SoakBounds& bounds);

}  // namespace tandem::testing
