#pragma once

#include <string>

namespace tandem {

/// What a driver says is there and is missing, as one JSON object: `name`, `kind`, `options`, and
/// `devices`, each with `model`, `options`, `present`, `missing` and `mend`; or `name` and `error`,
/// where the driver cannot be loaded. Loads the driver; opens no device. May take seconds.
std::string DevicesOf(const std::string& driver);

}  // namespace tandem
