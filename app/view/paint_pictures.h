#pragma once

#include <filesystem>

namespace tandem {

/// Paints each picture of a file (app/picture/picture_file.h) as NAME.png into that folder, at
/// twice its size. Needs only Qt, neither a display nor OpenGL. Returns the exit code; one line
/// says what is wrong.
int PaintPictures(const std::filesystem::path& pictures, const std::filesystem::path& folder);

}  // namespace tandem
