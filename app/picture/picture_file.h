#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/picture/picture.h"
#include "engine/base/result.h"

namespace tandem {

/// Writes pictures as JSON, for a program that paints what another program drew: {"pictures":
/// [{"name", "title", "width", "height", "shapes": [{"rectangle" | "polyline" | "marker" | "label":
/// {...}}]}]}. Colours are "#rrggbb".
std::string JsonOf(const std::vector<Picture>& pictures);

/// Errors name the file, the place in it and what was expected there. A name that is not a plain
/// file name is an error.
Result<std::vector<Picture>> ReadPictures(const std::filesystem::path& file);

}  // namespace tandem
