#pragma once

#include <string>

namespace tandem {

/// Returns a JSON value as text, whatever its strings hold: bytes that are not UTF-8 are replaced
/// instead of causing an exception. `indent`: below 0, one line.
template <typename Json>
std::string JsonText(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tandem
