#include "app/view/model/scene/drawn_scene.h"
#include "app/view/model/scene/refined_mesh.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/scene/scene_hash.h"

namespace tandem {

namespace {

// limits for moving bodies, whose vertices show distances
constexpr double kLongestSide = 4;  // voxels
constexpr std::size_t kMostVertices = 200'000;

}  // namespace

Result<DrawnScene> LoadDrawnScene(const std::filesystem::path& file, const LoadProgress& progress) {
  const Error given_up{"loading was cancelled"};
  if (!progress(0, 1, file.filename().string())) return given_up;
  const Result<Scene> scene = LoadScene(file);
  if (!scene) return scene.error();
  const Result<SceneHash> hash = HashScene(*scene);
  if (!hash) return hash.error();

  DrawnScene drawn;
  drawn.name = scene->name;
  drawn.file = file;
  drawn.digest = hash->digest;
  drawn.source = *scene;
  drawn.hashes = *hash;
  drawn.voxel_size = scene->voxel_size;
  drawn.range_voxels = scene->range_voxels;
  for (std::size_t i = 0; i < scene->bodies.size(); ++i) {
    const SceneBody& body = scene->bodies[i];
    if (!progress(drawn.bodies.size(), scene->bodies.size(), body.mesh.filename().string())) {
      return given_up;
    }
    ImportOptions options;
    options.scale = body.scale;
    options.part = body.part;
    const Result<TriangleMesh> mesh_M = ImportMesh(body.mesh, options);
    if (!mesh_M) return mesh_M.error();
    BodyLook look{body.fixed, body.colour};
    if (const std::size_t whole = scene->WholeOf(i); whole != i) look.part_of = whole;
    drawn.bodies.push_back(MakeDrawnBody(body.name, look, Transformed(*mesh_M, body.X_WM)));
    if (!body.fixed) {
      Refine(drawn.bodies.back().mesh, kLongestSide * scene->voxel_size, kMostVertices);
    }
  }
  return drawn;
}

}  // namespace tandem
