#pragma once

#include <string>

namespace tandem {

/// A JSON value as text, whatever its strings hold: what is not UTF-8 is replaced, never thrown at.
/// `indent`: below 0, one line.
template <typename Json>
std::string JsonText(const Json& json, int indent = -1) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tandem
