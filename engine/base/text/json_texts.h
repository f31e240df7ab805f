#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.h"

namespace tandem {

/// Returns the texts under `key` anywhere within the values that the root object has under `outer`,
/// in their order. A key that is given twice counts twice. Keeps nothing else of `text`, which may
/// be as large as memory holds. The error is without a name: the text is no JSON, or has more than
/// `most` such texts.
Result<std::vector<std::string>> TextsWithin(std::string_view text, std::string_view outer,
                                             std::string_view key, std::size_t most);

}  // namespace tandem
