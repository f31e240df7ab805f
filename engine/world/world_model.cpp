#include "engine/world/world_model.h"

#include "engine/geometry/mass_properties.h"
#include "engine/geometry/mesh_file.h"
#include "engine/voxel/voxelize.h"

namespace tandem {

namespace {

Error At(const SceneBody& body, const std::string& what) {
  return Error{"body '" + body.name + "' (" + body.mesh.string() + "): " + what};
}

Result<BodyModel> LoadBody(const Scene& scene, const SceneBody& body, const TriangleMesh& mesh_W,
                           const TriangleMesh& mesh_M, bool with_voxmap) {
  const MassProperties mass = ComputeMassProperties(mesh_M);
  BodyModel model;
  model.name = body.name;
  model.X_MB = {Quat::Identity(), mass.p_MBo};
  model.X_WB0 = body.X_WM * model.X_MB;
  model.inertia.mass = body.mass > 0 ? body.mass : body.density * std::abs(mass.volume);
  model.inertia.I_B = model.inertia.mass * mass.unit_inertia;
  if (!(model.inertia.mass > 0) || !(model.inertia.I_B.determinant() > 0)) {
    return At(body, "has no mass to move: give mass_kg, or a mesh with some extent");
  }
  Result<Pointshell> points = MakePoints(scene, mesh_W, model.X_WB0, body.inward_shift_voxels);
  if (!points) return At(body, points.error().what);
  model.points = std::move(*points);
  if (with_voxmap) {
    if (const auto fault = MakeMap(scene, mesh_W, model.voxmap, model.details)) {
      return At(body, fault->what);
    }
    model.X_BV = model.X_WB0.Inverse() * Pose{Quat::Identity(), model.voxmap.p_WVo()};
  }
  return model;
}

}  // namespace

std::optional<Error> MakeMap(const Scene& scene, const TriangleMesh& mesh_W, Voxmap& voxmap,
                             SurfaceDetails& details) {
  const double flatness = FlatnessVoxels(scene.contact);
  Result<Voxmap> made =
      Voxelize(mesh_W, {.voxel_size = scene.voxel_size, .flatness_voxels = flatness});
  if (!made) return made.error();
  voxmap = std::move(*made);
  if (scene.contact == ContactModel::kRefined) {
    details = SurfaceDetails(mesh_W, flatness, voxmap);
  }
  return std::nullopt;
}

Result<Pointshell> MakePoints(const Scene& scene, const TriangleMesh& mesh_W, const Pose& X_WB,
                              double inward_shift_voxels) {
  const bool refined = scene.contact == ContactModel::kRefined;
  return MakePointshell(mesh_W, X_WB,
                        {.spacing = scene.voxel_size,
                         .inward_shift = inward_shift_voxels * scene.voxel_size,
                         .place = refined ? PointPlace::kOnFeature : PointPlace::kVoxelCentre,
                         .flatness_voxels = FlatnessVoxels(scene.contact)});
}

Result<std::shared_ptr<const WorldModel>> LoadWorld(const Scene& scene) {
  auto world = std::make_shared<WorldModel>();
  world->scene = scene;
  std::size_t moving = 0;
  for (const SceneBody& body : scene.bodies) moving += body.fixed ? 0 : 1;
  TriangleMesh fixture_W;
  for (std::uint32_t index = 0; index < scene.bodies.size(); ++index) {
    const SceneBody& body = scene.bodies[index];
    Result<TriangleMesh> mesh_M = ImportMesh(body.mesh, {.scale = body.scale});
    if (!mesh_M) return At(body, mesh_M.error().what);
    const MeshDiagnosis diagnosis = Diagnose(*mesh_M);
    if (!diagnosis.closed()) world->remarks.push_back(At(body, Describe(diagnosis)).what);
    const TriangleMesh& mesh_W = world->meshes_W.emplace_back(Transformed(*mesh_M, body.X_WM));
    if (body.fixed) {
      Append(fixture_W, mesh_W);
      world->body_index.push_back(-1);
      continue;
    }
    Result<BodyModel> model = LoadBody(scene, body, mesh_W, *mesh_M, moving > 1);
    if (!model) return model.error();
    world->body_index.push_back(static_cast<int>(world->bodies.size()));
    world->bodies.push_back(std::move(*model));
    world->object.push_back(index);
  }
  if (world->bodies.empty()) return Error{scene.file.string() + ": no body can move"};
  if (!fixture_W.triangles.empty()) {
    if (const auto fault = MakeMap(scene, fixture_W, world->fixture, world->fixture_details)) {
      return Error{scene.file.string() + ": the fixed bodies: " + fault->what};
    }
    world->has_fixture = true;
  }
  return std::shared_ptr<const WorldModel>(std::move(world));
}

}  // namespace tandem
