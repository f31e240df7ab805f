#pragma once

#include <filesystem>

#include "app/cli/child_processes.h"

namespace tandem {

/// Where the stability lab's own scenes and presets are: build/bin/tandem reads
/// build/scenes/stability.
inline std::filesystem::path LabSceneFolder() {
  return ProgramFolder().parent_path() / "scenes" / "stability";
}

}  // namespace tandem
