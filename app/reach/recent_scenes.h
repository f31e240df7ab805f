#pragma once

#include <filesystem>
#include <vector>

namespace tandem {

/// Returns the scene files that a person opened last, the newest first, as far as they are there.
std::vector<std::filesystem::path> RecentScenes();

/// Puts a file first among them, in `tandem/recent_scenes` of $XDG_STATE_HOME (~/.local/state).
/// Does nothing where it cannot.
void RememberScene(const std::filesystem::path& file);

}  // namespace tandem
