#pragma once

#include <filesystem>

#include "app/common/program_folders.h"

namespace tandem {

/// Returns the folder of the stability lab's own scenes and presets.
inline std::filesystem::path LabSceneFolder() {
  return SceneFolder() / "stability";
}

}  // namespace tandem
