#pragma once

#include <string>

namespace tandem {

/// Returns what a driver finds and misses, as one JSON object: `name`, `kind`, `options`, and
/// `devices`, each with `model`, `options`, `present`, `missing` and `mend`. Where the driver
/// cannot be loaded, the object has `name` and `error`. Loads the driver but opens no device. May
/// take seconds.
std::string DevicesOf(const std::string& driver);

}  // namespace tandem
