#pragma once

#include <filesystem>

namespace tandem {

/// Times the pictures of a scene with the renderer alone, in a framebuffer without a window. Writes
/// a JSON file with the times of full redraws, of frames in which only bodies move, and of frames
/// in which the eye moves. A large scene is timed as a whole and in part, in turn. Needs a
/// QGuiApplication. Returns the exit code; one line says what is wrong.
int TimePictures(const std::filesystem::path& scene, int rounds, const std::filesystem::path& file);

}  // namespace tandem
