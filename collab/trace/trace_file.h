#pragma once

#include <filesystem>
#include <optional>

#include "collab/trace/network_trace.h"
#include "engine/base/result.h"

namespace tandem {

inline constexpr std::size_t kMostTraceSamples = 4'000'000;  // an hour at 1 kHz
inline constexpr double kMostTraceHz = 10'000;
inline constexpr double kLongestTracedMs = 10'000;

/// Reads a trace (docs/network-plans.md): a line "# {JSON}", a line of columns, a row for each
/// sample. The file is not trusted. Errors name the file and the line.
Result<NetworkTrace> ReadNetworkTrace(const std::filesystem::path& file);

/// Writes a file for ReadNetworkTrace(), with delays rounded to a microsecond.
std::optional<Error> WriteNetworkTrace(const std::filesystem::path& file,
                                       const NetworkTrace& trace);

/// Returns the delay as in a file: rounded to a microsecond.
float AsInFile(double delay_ms);

}  // namespace tandem
