#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "app/view/model/scene/picture_composer.h"
#include "app/view/model/scene/shaded_mesh.h"
#include "engine/base/result.h"
#include "engine/scene/scene_hash.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

/// A body of a scene in its first place, with its mesh in W.
struct DrawnBody {
  std::string name;
  BodyLook look;
  ShadedMesh mesh;
  Bounds bounds_W;
  std::size_t file_triangles = 0;  // triangles as read, before any are cut for drawing
};

/// A scene ready for drawing. Its bodies are numbered as in the session.
struct DrawnScene {
  std::string name;
  std::filesystem::path file;
  Sha256 digest{};        // digest of its content, as in SceneHash
  double voxel_size = 0;  // m
  int range_voxels = kDefaultRange;
  std::vector<DrawnBody> bodies;
  Scene source;      // scene as read, without meshes
  SceneHash hashes;  // hashes of `source`, by body

  Bounds BoundsOfAll() const;
  std::size_t TriangleCount() const;      // number as drawn with vertex colours
  std::size_t FileTriangleCount() const;  // number in the mesh files
  std::vector<BodyLook> Looks() const;
};

/// Is called before each step of loading. Returns whether to go on.
using LoadProgress =
    std::function<bool(std::size_t done, std::size_t total, const std::string& what)>;

/// Loads and prepares a scene. It takes up to many seconds, so it does not run on the GUI thread.
/// Errors: those of LoadScene, HashScene and ImportMesh, or loading was given up.
using LoadFunction =
    std::function<Result<DrawnScene>(const std::filesystem::path& file, const LoadProgress&)>;
Result<DrawnScene> LoadDrawnScene(const std::filesystem::path& file, const LoadProgress& progress);

/// Makes a scene's body from its mesh in W.
DrawnBody MakeDrawnBody(const std::string& name, const BodyLook& look, const TriangleMesh& mesh_W);

}  // namespace tandem
