#pragma once

#include <span>
#include <string_view>

namespace tandem {

/// A reader of what strangers write, fed with any bytes. A run ends the program where the reader
/// breaks its word: it crashes, or what it says of a fault is not one plain line.
struct FuzzTarget {
  const char* name;
  void (*run)(std::string_view bytes);
};

std::span<const FuzzTarget> FuzzTargets();
/// Returns the target of that name; null: there is none.
const FuzzTarget* FuzzTargetNamed(std::string_view name);

}  // namespace tandem
