#pragma once

#include <filesystem>
#include <string>

namespace tandem {

/// The file of a scene: one of ours by its name, or any by its path.
std::filesystem::path SceneFile(const std::string& name_or_path);

}  // namespace tandem
