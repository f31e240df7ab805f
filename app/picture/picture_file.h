#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/picture/picture.h"
#include "engine/base/result.h"

namespace tandem {

/// Pictures as JSON, from the program that makes them to the one that paints them: {"pictures":
/// [{"name", "title", "width", "height", "shapes": [{"rectangle" | "polyline" | "marker" | "label":
/// {...}}]}]}. Colours are "#rrggbb".
std::string JsonOf(const std::vector<Picture>& pictures);

/// Errors name the file, the place in it and what was expected there; a name that is no plain file
/// name is one.
Result<std::vector<Picture>> ReadPictures(const std::filesystem::path& file);

}  // namespace tandem
