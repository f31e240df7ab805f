#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "collab/trace/network_trace.h"

namespace tandem {

/// Returns a line for each direction of a trace, with its delays and losses for a person.
std::string FactsAsText(const NetworkTrace& trace);
nlohmann::ordered_json FactsAsJson(const NetworkTrace& trace);

}  // namespace tandem
