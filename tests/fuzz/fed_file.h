#pragma once

#include <filesystem>
#include <string_view>

#include "engine/base/check.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/result.h"

namespace tandem {

/// Writes `bytes` into a regular file in memory, which lasts until the next call, and returns its
/// path.
std::filesystem::path FedFile(std::string_view bytes);

/// Checks the promise of every reader on a refusal: one line that a terminal shows as it is.
template <typename T>
void ExpectPlain(const Result<T>& result) {
  if (result) return;
  TANDEM_CHECK(!result.error().what.empty());
  TANDEM_CHECK(IsPlainText(result.error().what));
  TANDEM_CHECK(result.error().what.size() < 8192);
}

}  // namespace tandem
