#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/scene/scene.h"

namespace tandem {

/// Returns the file of a scene: one of ours by its name, or any by its path.
std::filesystem::path SceneFile(const std::string& name_or_path);

/// Loads a scene. An error says what is wrong with it, or which scenes there are.
Result<Scene> LoadNamedScene(const std::string& name_or_path);

/// Does ImportMesh(), and says what the file asks for and its reader does not honour, a line each.
/// `remarks`: takes the same lines; null: nobody wants them.
Result<TriangleMesh> ImportAndTell(const std::filesystem::path& file, const ImportOptions& options,
                                   std::vector<std::string>* remarks = nullptr);

}  // namespace tandem
