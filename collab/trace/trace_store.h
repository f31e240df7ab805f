#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "collab/link_conditioner.h"
#include "engine/base/json_reader.h"
#include "engine/base/result.h"

namespace tandem {

/// Which way of a network's trace.
enum class TraceWay : std::uint8_t { kThere, kBack };

/// The traces of this program: each is read, or made, once and kept until the program ends, so that
/// threads may use it without counting. A file that has changed is another trace. From any thread.
Result<const LinkTrace*> KeepTrace(const std::filesystem::path& file, TraceWay way, double stretch);
/// The same of a model's first two minutes at 1 kHz (trace_models.h), with seed 1. Errors: there is
/// no model of that name.
Result<const LinkTrace*> KeepModel(const std::string& name, TraceWay way, double stretch);

/// What a plan's step or a case's network says of traces: `trace` (a file in `folder`) or `model`,
/// `stretch`, `start_s`, `mix`.
struct TraceChoice {
  const LinkTrace* there = nullptr;  // null: no trace is named
  const LinkTrace* back = nullptr;
  double start_s = 0;
  bool mix = false;  // begins at a place that the seed tells

  /// Where a run of that seed begins.
  double StartFor(std::uint64_t seed) const;
};
inline constexpr const char* kTraceKeys[] = {"trace", "model", "stretch", "start_s", "mix"};

/// Faults are noted at the node.
TraceChoice ReadTraceKeys(const JsonNode& node, const std::filesystem::path& folder);

}  // namespace tandem
