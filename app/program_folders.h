#pragma once

#include <filesystem>

namespace tandem {

/// Returns the folder that this program lies in, where its sister programs are.
std::filesystem::path ProgramFolder();

/// Returns the folder of the scenes that come with this program: `share/tandem/scenes` beside the
/// `bin` of an installation, wherever that was put or moved; the build tree's `scenes` otherwise.
std::filesystem::path SceneFolder();

}  // namespace tandem
