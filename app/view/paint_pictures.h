#pragma once

#include <filesystem>

namespace tandem {

/// Paints the pictures of a file (app/picture/picture_file.h) as NAME.png each into that folder, at
/// twice their size; needs no display and no OpenGL, only Qt. Gives the exit code; what is wrong is
/// told in one line.
int PaintPictures(const std::filesystem::path& pictures, const std::filesystem::path& folder);

}  // namespace tandem
