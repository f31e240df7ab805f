#pragma once

#include <filesystem>
#include <vector>

namespace tandem {

/// Returns the scene files that a person opened last and that still exist, the newest first.
std::vector<std::filesystem::path> RecentScenes();

/// Puts a file first in this list, `tandem/recent_scenes` in $XDG_STATE_HOME (~/.local/state). Does
/// nothing where it cannot write.
void RememberScene(const std::filesystem::path& file);

}  // namespace tandem
