#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <variant>

#include "collab/lab/metrics/metrics.h"

namespace tandem {

/// A figure of Metrics and its name. The code that writes, reads, compares and hashes figures uses
/// this table, so that none is forgotten.
struct MetricField {
  std::string_view name;
  std::variant<double Metrics::*, bool Metrics::*, int Metrics::*, std::int64_t Metrics::*> member;
};

/// Returns all fields in the order of the struct.
std::span<const MetricField> MetricFields();

}  // namespace tandem
