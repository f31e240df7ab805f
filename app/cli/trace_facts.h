#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "collab/trace/network_trace.h"

namespace tandem {

/// What a trace comes to, each way: a line for each, for a person.
std::string FactsAsText(const NetworkTrace& trace);
nlohmann::ordered_json FactsAsJson(const NetworkTrace& trace);

}  // namespace tandem
