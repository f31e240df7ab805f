#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "engine/base/result.h"
#include "engine/contact/field/field_pair.h"
#include "engine/contact/kept/voxel_cache.h"
#include "engine/contact/pair/contact_pair.h"
#include "engine/dynamics/constraint.h"
#include "engine/dynamics/rigid_body.h"
#include "engine/geometry/mesh/mesh_diagnosis.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/scene/scene.h"
#include "engine/voxel/map/voxmap.h"
#include "engine/voxel/points/pointshell.h"

namespace tandem {

/// A moving body as loaded, with the parts merged with it: all that does not change while it moves.
struct BodyModel {
  std::string name;
  Pose X_WB0;  // first pose of its frame B: origin at the centre of mass, axes of the file
  Pose X_MB;   // B in the file's frame
  Inertia inertia;
  std::optional<Constraint> constraint;
  double radius = 0;  // largest distance of its surface from B's origin, m
  /// The number of points of its spacing for which its surface has room, about.
  double surface_points = 0;
  // for the plain contact model; AddPlainParts() makes them for the refined model too
  Pointshell points;  // in B
  Voxmap voxmap;      // empty unless another moving body may meet it
  Pose X_BV;          // pose of the voxmap's frame
  // for the refined contact model
  BodySurface surface;
};

/// A scene with its meshes loaded and voxelized. Read-only and shared by all that simulate or judge
/// it.
struct WorldModel {
  Scene scene;
  std::vector<TriangleMesh> meshes_W;  // all bodies of the scene in their first poses
  std::vector<int> body_index;         // per scene body: index into `bodies`, or -1 when fixed
  std::vector<BodyModel> bodies;       // moving bodies, each with the parts merged with it
  std::vector<std::uint32_t> object;   // per moving body: its number in the scene
  Voxmap fixture;                      // all fixed bodies merged, for the plain contact model
  /// The same where it may be in memory in part only; `fixture` is empty then.
  std::shared_ptr<const PageSource> fixture_pages;
  /// Bytes that each world of this model may take for these voxels.
  std::uint64_t voxel_memory_bytes = 0;
  BodySurface fixture_surface;  // the same for the refined contact model
  bool has_fixture = false;
  std::vector<std::string> remarks;  // remarks on the meshes for a person: open edges, …

  /// Returns the moving body that the scene's body of that name is, or is a part of; -1 for none.
  int BodyNamed(const std::string& name) const {
    const int body = scene.BodyNamed(name);
    return body < 0 ? -1 : body_index[static_cast<std::size_t>(body)];
  }
};

/// Returns the mesh of a moving body with the parts merged with it, in its first pose.
TriangleMesh MeshOfBody(const WorldModel& world, std::size_t body);

/// Counts what contact tests of a body: the points of its pointshell, or its feature points.
std::size_t TestedPoints(const WorldModel& world, const BodyModel& body);
/// Counts what contact reads of a body or of the fixture: the voxels that a voxmap stores, or the
/// cells that a distance field stores.
std::size_t ReadVoxels(const WorldModel& world, const Voxmap& voxmap, const BodySurface& surface);

/// Counts the same for the fixture, wherever its voxels are.
std::size_t FixtureVoxels(const WorldModel& world);

/// Makes the pointshells and voxmaps of a world of the refined contact model, for comparisons. The
/// refined model reads none of them.
std::optional<Error> AddPlainParts(WorldModel& world);

/// Returns a remark on a body whose neighbouring points part by more than a voxel when they are
/// displaced by `displacement` (m) more along their inward normals. They part where the surface
/// curves away from that direction (paper §3.2). Returns nothing for the refined contact model,
/// which tests no points of faces.
std::optional<std::string> GapRemark(const Scene& scene, const BodyModel& body,
                                     double displacement);

/// Options of loading a scene.
struct LoadOptions {
  /// When it is asked to stop, a loader soon ends with an error.
  std::stop_token stop = {};
  /// The cache of what is made of meshes, kept from one program to the next; null: none. Used while
  /// loading.
  const VoxelCache* cache = nullptr;
  /// The most memory that voxels of the fixed bodies may take, bytes. The rest is read when it is
  /// needed (paper §5.3), or computed without a cache. 0: all are in memory. Needs the plain
  /// contact model.
  std::uint64_t voxel_memory_bytes = 0;
  /// The greatest rate of a disk, bytes/s, for measurements; 0: unlimited.
  double disk_bytes_per_s = 0;
};

/// Makes the parts of a moving body that the scene's contact model needs from its mesh, in its
/// frame at X_WB0. `with_voxmap`: another moving body may meet it.
std::optional<Error> MakeShape(const Scene& scene, const SceneBody& body,
                               const TriangleMesh& mesh_W, bool with_voxmap, BodyModel& model,
                               const LoadOptions& options = {});
/// Does the same for all fixed bodies together.
std::optional<Error> MakeFixture(const TriangleMesh& mesh_W, WorldModel& world,
                                 const LoadOptions& options = {});
/// Makes the voxmap of a mesh, against which plain contact tests points.
std::optional<Error> MakeMap(const Scene& scene, const TriangleMesh& mesh_W, Voxmap& voxmap,
                             const LoadOptions& options = {});
/// Makes the surface of a mesh for refined contact, in the frame that stands at X_WB.
Result<BodySurface> MakeSurface(const Scene& scene, const TriangleMesh& mesh_W, const Pose& X_WB,
                                double spacing_voxels = 1, const LoadOptions& options = {});
/// Makes the points of a mesh for plain contact, in the frame that stands at X_WB; lengths in
/// voxels of the scene.
Result<Pointshell> MakePoints(const Scene& scene, const TriangleMesh& mesh_W, const Pose& X_WB,
                              double inward_shift_voxels, double spacing_voxels = 1,
                              const LoadOptions& load = {});

/// Loads a scene: imports, welds, weighs and voxelizes its meshes. Errors name the body and its
/// file.
Result<std::shared_ptr<const WorldModel>> LoadWorld(const Scene& scene,
                                                    const LoadOptions& options = {});

}  // namespace tandem
