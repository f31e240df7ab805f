#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "engine/base/result.h"
#include "engine/contact/contact_pair.h"
#include "engine/contact/field_pair.h"
#include "engine/contact/voxel_cache.h"
#include "engine/dynamics/constraint.h"
#include "engine/dynamics/rigid_body.h"
#include "engine/geometry/mesh_diagnosis.h"
#include "engine/geometry/triangle_mesh.h"
#include "engine/voxel/pointshell.h"
#include "engine/voxel/voxmap.h"
#include "engine/world/scene.h"

namespace tandem {

/// A moving body as loaded, with the parts merged with it: what never changes while it moves.
struct BodyModel {
  std::string name;
  Pose X_WB0;  // first pose of its frame B: origin at the centre of mass, axes of the file
  Pose X_MB;   // B in the file's frame
  Inertia inertia;
  std::optional<Constraint> constraint;
  double radius = 0;  // largest distance of its surface from B's origin, m
  /// How many points of its spacing its surface has room for, about.
  double surface_points = 0;
  // of the plain contact model; AddPlainParts() makes them for the refined one too
  Pointshell points;  // in B
  Voxmap voxmap;      // empty unless another moving body may meet it
  Pose X_BV;          // of the voxmap
  // of the refined contact model
  BodySurface surface;
};

/// A scene with its meshes loaded and voxelized: read-only, shared by whoever simulates or judges
/// it.
struct WorldModel {
  Scene scene;
  std::vector<TriangleMesh> meshes_W;  // every body of the scene, where it stands at first
  std::vector<int> body_index;         // per scene body: into `bodies`, or -1 when fixed
  std::vector<BodyModel> bodies;       // the moving ones, each with the parts merged with it
  std::vector<std::uint32_t> object;   // per moving body: its number in the scene
  Voxmap fixture;                      // all fixed bodies merged, of the plain contact model
  /// The same where it may be in memory in part only; `fixture` is empty then.
  std::shared_ptr<const PageSource> fixture_pages;
  std::uint64_t voxel_memory_bytes = 0;  // that each world of this model may take for these
  BodySurface fixture_surface;           // the same of the refined contact model
  bool has_fixture = false;
  std::vector<std::string> remarks;  // of the meshes, for a person: open edges, …

  /// The moving body that the scene's body of that name is, or is a part of; -1 for none.
  int BodyNamed(const std::string& name) const {
    const int body = scene.BodyNamed(name);
    return body < 0 ? -1 : body_index[static_cast<std::size_t>(body)];
  }
};

/// The mesh of a moving body with the parts merged with it, where it stands at first.
TriangleMesh MeshOfBody(const WorldModel& world, std::size_t body);

/// Counts what contact tests of a body: the points of its pointshell, or its feature points.
std::size_t TestedPoints(const WorldModel& world, const BodyModel& body);
/// Counts what contact reads of a body or of the fixture: the voxels that a voxmap stores, or the
/// cells that a distance field does.
std::size_t ReadVoxels(const WorldModel& world, const Voxmap& voxmap, const BodySurface& surface);

/// The same of the fixture, wherever its voxels are.
std::size_t FixtureVoxels(const WorldModel& world);

/// Makes the pointshells and voxmaps of a world of the refined contact model, which reads none of
/// them: for comparisons.
std::optional<Error> AddPlainParts(WorldModel& world);

/// What to say of a body whose neighbouring points part by more than a voxel, displaced by so many
/// metres more along their inward normals: they do where the surface curves away from where they go
/// (paper §3.2). Nothing in the refined contact model, which tests no points of faces.
std::optional<std::string> GapRemark(const Scene& scene, const BodyModel& body,
                                     double displacement);

/// How a scene is loaded.
struct LoadOptions {
  /// Asked to stop, a loader soon ends with an error.
  std::stop_token stop = {};
  /// Where what is made of meshes is kept from one program to the next; null: nowhere. Used while
  /// loading.
  const VoxelCache* cache = nullptr;
  /// The most memory that voxels of the fixed bodies may take, bytes: the rest is read as it is
  /// needed (paper §5.3), or computed where nothing is kept. 0: all are in memory. Needs the plain
  /// contact model.
  std::uint64_t voxel_memory_bytes = 0;
  /// What a disk gives in a second at most, bytes, for measurements; 0: what it does.
  double disk_bytes_per_s = 0;
};

/// Makes what the scene's contact model meets of a moving body's mesh, in its frame at X_WB0.
/// `with_voxmap`: another moving body may meet it.
std::optional<Error> MakeShape(const Scene& scene, const SceneBody& body,
                               const TriangleMesh& mesh_W, bool with_voxmap, BodyModel& model,
                               const LoadOptions& options = {});
/// The same of all fixed bodies together.
std::optional<Error> MakeFixture(const TriangleMesh& mesh_W, WorldModel& world,
                                 const LoadOptions& options = {});
/// A mesh as what plain contact tests others against.
std::optional<Error> MakeMap(const Scene& scene, const TriangleMesh& mesh_W, Voxmap& voxmap,
                             const LoadOptions& options = {});
/// A mesh as refined contact meets it, in the frame that stands at X_WB.
Result<BodySurface> MakeSurface(const Scene& scene, const TriangleMesh& mesh_W, const Pose& X_WB,
                                double spacing_voxels = 1, const LoadOptions& options = {});
/// A mesh as what is tested, in the frame that stands at X_WB; lengths in voxels of the scene.
Result<Pointshell> MakePoints(const Scene& scene, const TriangleMesh& mesh_W, const Pose& X_WB,
                              double inward_shift_voxels, double spacing_voxels = 1,
                              const LoadOptions& load = {});

/// Imports, welds, weighs and voxelizes. Errors name the body and its file.
Result<std::shared_ptr<const WorldModel>> LoadWorld(const Scene& scene,
                                                    const LoadOptions& options = {});

}  // namespace tandem
