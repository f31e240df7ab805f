#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"

namespace tandem {

/// Runs `openssl` with these arguments and returns its output, or its last line as the error. It
/// makes and compares keys before a session; secrets pass through files only.
Result<std::string> Openssl(std::vector<std::string> arguments);

/// Returns the public key of a certificate (PEM), for comparison.
Result<std::string> PublicKeyOf(const std::filesystem::path& certificate);

}  // namespace tandem
