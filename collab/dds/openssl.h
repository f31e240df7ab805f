#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"

namespace tandem {

/// Runs `openssl` with these arguments and gives what it printed, or its last words as the error.
/// For making and comparing keys before a session; secrets pass through files only.
Result<std::string> Openssl(std::vector<std::string> arguments);

/// The public key of a certificate (PEM), to be compared.
Result<std::string> PublicKeyOf(const std::filesystem::path& certificate);

}  // namespace tandem
