#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <variant>

#include "collab/lab/metrics.h"

namespace tandem {

/// A figure of Metrics under its name: what is written, read, compared and hashed goes through this
/// table, so that none is forgotten in one of them.
struct MetricField {
  std::string_view name;
  std::variant<double Metrics::*, bool Metrics::*, int Metrics::*, std::int64_t Metrics::*> member;
};

/// All of them, in the order of the struct.
std::span<const MetricField> MetricFields();

}  // namespace tandem
