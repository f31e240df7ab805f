#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "collab/trace/network_trace.h"

namespace tandem {

/// Returns a line for each way of a trace, which tells a person its delays and losses.
std::string FactsAsText(const NetworkTrace& trace);
nlohmann::ordered_json FactsAsJson(const NetworkTrace& trace);

}  // namespace tandem
