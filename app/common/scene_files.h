#pragma once

#include <filesystem>
#include <string>

#include "engine/base/result.h"
#include "engine/scene/scene.h"

namespace tandem {

/// Returns the file of a scene: one of ours by its name, or any by its path.
std::filesystem::path SceneFile(const std::string& name_or_path);

/// Loads a scene. An error says what is wrong with it, or which scenes there are.
Result<Scene> LoadNamedScene(const std::string& name_or_path);

}  // namespace tandem
