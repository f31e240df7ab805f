#pragma once

#include <filesystem>
#include <string_view>

#include "engine/base/check.h"
#include "engine/base/regular_file.h"
#include "engine/base/result.h"

namespace tandem {

/// A regular file in memory that holds `bytes`, until the next call.
std::filesystem::path FedFile(std::string_view bytes);

/// What every reader promises of what it refuses: one line that a terminal shows as it is.
template <typename T>
void ExpectPlain(const Result<T>& result) {
  if (result) return;
  TANDEM_CHECK(!result.error().what.empty());
  TANDEM_CHECK(IsPlainText(result.error().what));
  TANDEM_CHECK(result.error().what.size() < 8192);
}

}  // namespace tandem
