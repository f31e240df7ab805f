#pragma once

#include <filesystem>
#include <string>

#include "engine/base/result.h"
#include "engine/world/scene.h"

namespace tandem {

/// The file of a scene: one of ours by its name, or any by its path.
std::filesystem::path SceneFile(const std::string& name_or_path);

/// Loads it. An error says what is wrong with it, or which ones there are.
Result<Scene> LoadNamedScene(const std::string& name_or_path);

}  // namespace tandem
