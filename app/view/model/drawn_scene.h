#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "app/view/model/picture_composer.h"
#include "app/view/model/shaded_mesh.h"
#include "engine/base/result.h"
#include "engine/voxel/voxel.h"
#include "engine/world/scene_hash.h"

namespace tandem {

/// A body of a scene with its mesh in W, as it stands at first.
struct DrawnBody {
  std::string name;
  BodyLook look;
  ShadedMesh mesh;
  Bounds bounds_W;
  std::size_t file_triangles = 0;  // as read, before any are cut for drawing
};

/// A scene ready for drawing. Its bodies are numbered as in the session.
struct DrawnScene {
  std::string name;
  std::filesystem::path file;
  std::uint64_t hash = 0;
  double voxel_size = 0;  // m
  int range_voxels = kDefaultRange;
  std::vector<DrawnBody> bodies;
  Scene source;      // what was read, without meshes
  SceneHash hashes;  // of it, by body

  Bounds BoundsOfAll() const;
  std::size_t TriangleCount() const;      // as drawn with vertex colours
  std::size_t FileTriangleCount() const;  // in its mesh files
  std::vector<BodyLook> Looks() const;
};

/// Told before each step of loading; answers whether to go on.
using LoadProgress =
    std::function<bool(std::size_t done, std::size_t total, const std::string& what)>;

/// Loads and prepares a scene: a fraction of a second to many seconds, so not on the GUI thread.
/// Errors: what LoadScene, HashScene and ImportMesh say, or that it was given up.
using LoadFunction =
    std::function<Result<DrawnScene>(const std::filesystem::path& file, const LoadProgress&)>;
Result<DrawnScene> LoadDrawnScene(const std::filesystem::path& file, const LoadProgress& progress);

/// A scene's body from its mesh in W.
DrawnBody MakeDrawnBody(const std::string& name, const BodyLook& look, const TriangleMesh& mesh_W);

}  // namespace tandem
