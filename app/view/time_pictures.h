#pragma once

#include <filesystem>

namespace tandem {

/// Times the renderer with the pictures of a scene, in a framebuffer without a window. Writes a
/// JSON file with the times of full redraws, of frames in which only bodies move, and of frames in
/// which the eye moves. A large scene is also timed in part, in turn with the whole. Needs a
/// QGuiApplication. Returns the exit code; one line says what is wrong.
int TimePictures(const std::filesystem::path& scene, int rounds, const std::filesystem::path& file);

}  // namespace tandem
