#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "collab/receive/link_conditioner.h"
#include "engine/base/result.h"
#include "engine/base/text/json_reader.h"

namespace tandem {

/// A way of a network's trace.
enum class TraceDirection : std::uint8_t { kThere, kBack };

/// Returns one way of a trace file. The program reads or makes each trace once and keeps it until
/// its end, so that threads may use it without counting. A changed file is another trace. From any
/// thread.
Result<const LinkTrace*> KeepTrace(const std::filesystem::path& file, TraceDirection way,
                                   double stretch);
/// Does the same for a model's first two minutes at 1 kHz (trace_models.h), with seed 1. Errors: no
/// model has that name.
Result<const LinkTrace*> KeepModel(const std::string& name, TraceDirection way, double stretch);

/// The trace named by a plan's step or a case's network: `trace` (a file in `folder`) or `model`,
/// `stretch`, `start_s`, `mix`.
struct TraceChoice {
  const LinkTrace* there = nullptr;  // null: no trace is named
  const LinkTrace* back = nullptr;
  double start_s = 0;
  bool mix = false;  // begins at a place that depends on the seed

  /// Returns where a run with that seed begins, s.
  double StartFor(std::uint64_t seed) const;
};
inline constexpr const char* kTraceKeys[] = {"trace", "model", "stretch", "start_s", "mix"};

/// Reads these keys. Faults are noted at the node.
TraceChoice ReadTraceKeys(const JsonNode& node, const std::filesystem::path& folder);

}  // namespace tandem
