#include "engine/world/world_model.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <tbb/parallel_for.h>

#include "engine/base/check.h"
#include "engine/contact/kept/surface_builder.h"
#include "engine/geometry/exact/union_mass.h"
#include "engine/geometry/import/declared_unit.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/paging/resident_voxels.h"
#include "engine/paging/slow_pages.h"
#include "engine/voxel/build/voxelize.h"
#include "engine/voxel/pages/computed_pages.h"

namespace tandem {

namespace {

Error At(const SceneBody& body, const std::string& what) {
  return Error{"body '" + body.name + "' (" + body.mesh.string() + "): " + what};
}

constexpr double kLarge = 2.0;  // m; larger than parts usually are

/// Returns a remark if nothing declares a file's unit, and the mesh is so large in metres that
/// millimetres are more likely.
std::optional<std::string> ScaleRemark(const SceneBody& body, const TriangleMesh& mesh_W) {
  const Vec3 size = BoundsOf(mesh_W).size();
  const bool has_unit = body.scale || KindDeclaresUnit(body.mesh);
  if (has_unit || size.maxCoeff() < kLarge) return std::nullopt;
  char text[160];
  std::snprintf(text, sizeof text,
                "it measures %.3g x %.3g x %.3g m: is the file in millimetres? Then give it "
                "\"scale\": 0.001",
                size.x(), size.y(), size.z());
  return text;
}

/// Returns the fault of a body that is too large for its voxels, with its likeliest reason first.
Error WithScale(const Error& fault, const SceneBody& body, const TriangleMesh& mesh_W) {
  const auto remark = ScaleRemark(body, mesh_W);
  return remark ? Error{*remark + " (" + fault.what + ")"} : fault;
}

/// Returns a body's mesh together with the meshes of the parts merged with it.
TriangleMesh WholeOf(const Scene& scene, const std::vector<TriangleMesh>& meshes_W,
                     std::size_t body) {
  TriangleMesh whole_W = meshes_W[body];
  for (std::size_t i = 0; i < meshes_W.size(); ++i) {
    if (i != body && scene.WholeOf(i) == body) Append(whole_W, meshes_W[i]);
  }
  return whole_W;
}

TriangleMesh FixtureOf(const Scene& scene, const std::vector<TriangleMesh>& meshes_W) {
  TriangleMesh fixture_W;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed) Append(fixture_W, meshes_W[i]);
  }
  return fixture_W;
}

/// Returns a rounded number, so that it does not depend on where a body stands.
double PointsOnSurface(const Scene& scene, const TriangleMesh& mesh_W, double spacing_voxels) {
  const double spacing = spacing_voxels * scene.voxel_size;
  return std::round(SurfaceArea(mesh_W) / (spacing * spacing));
}

std::optional<Error> MakePlainParts(const Scene& scene, const SceneBody& body,
                                    const TriangleMesh& mesh_W, bool with_voxmap,
                                    const LoadOptions& options, BodyModel& model) {
  Result<Pointshell> points = MakePoints(scene, mesh_W, model.X_WB0, body.inward_shift_voxels,
                                         body.point_spacing_voxels, options);
  if (!points) return points.error();
  model.points = std::move(*points);
  if (!with_voxmap) return std::nullopt;
  if (auto fault = MakeMap(scene, mesh_W, model.voxmap, options)) return fault;
  model.X_BV = model.X_WB0.Inverse() * Pose{Quat::Identity(), model.voxmap.p_WVo()};
  return std::nullopt;
}

/// Returns a remark if a body's mass is an estimate. Given mass, its centre and inertia are.
std::optional<std::string> MassRemark(const SceneBody& body, const UnionMass& mass, double kg) {
  char text[80];
  std::snprintf(text, sizeof text, "its mass of %.4g kg by density_kg_m3 ", kg);
  const std::string what = body.mass > 0 ? "its centre of mass and inertia " : std::string(text);
  if (mass.counts_twice) return what + kCountsTwice;
  if (mass.solid || body.mass > 0) return std::nullopt;
  return what +
         "is an estimate, for its surface encloses no sound volume: give mass_kg, or mend "
         "the mesh";
}

Result<BodyModel> LoadBody(const Scene& scene, const SceneBody& body, const TriangleMesh& mesh_W,
                           bool with_voxmap, const LoadOptions& options,
                           std::vector<std::string>& remarks) {
  const UnionMass mass = ComputeUnionMass(Transformed(mesh_W, body.X_WM.Inverse()));
  BodyModel model;
  model.name = body.name;
  model.X_MB = {Quat::Identity(), mass.p_MBo};
  model.X_WB0 = body.X_WM * model.X_MB;
  model.inertia.mass = body.mass > 0 ? body.mass : body.density * std::abs(mass.volume);
  model.inertia.I_B = model.inertia.mass * mass.unit_inertia;
  if (!(model.inertia.mass > 0) || !(model.inertia.I_B.determinant() > 0)) {
    return At(body, "has no mass to move: give mass_kg, or a mesh with some extent");
  }
  if (const auto remark = MassRemark(body, mass, model.inertia.mass)) {
    remarks.push_back(At(body, *remark).what);
  }
  if (body.constraint.kind != SceneConstraint::Kind::kNone) {
    model.constraint = MakeConstraint(body.constraint, model.X_WB0);
  }
  if (auto fault = MakeShape(scene, body, mesh_W, with_voxmap, model, options)) {
    return At(body, WithScale(*fault, body, mesh_W).what);
  }
  return model;
}

Error Stopped(const Scene& scene) {
  return Error{scene.file.string() + ": stopped while it was loaded"};
}

std::optional<Error> LoadMeshes(const Scene& scene, const LoadOptions& options, WorldModel& world) {
  std::vector<std::optional<Result<ImportedMesh>>> meshes_M(scene.bodies.size());
  tbb::parallel_for(std::size_t{0}, scene.bodies.size(), [&](std::size_t i) {
    const SceneBody& body = scene.bodies[i];
    if (options.stop.stop_requested()) return;
    const ImportOptions import{.scale = body.scale, .part = body.part};
    meshes_M[i] = options.cache != nullptr ? options.cache->MeshOf(body.mesh, import)
                                           : ImportAndDiagnose(body.mesh, import);
  });
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const SceneBody& body = scene.bodies[i];
    if (!meshes_M[i]) return Stopped(scene);
    if (!*meshes_M[i]) return At(body, meshes_M[i]->error().what);
    ImportedMesh& imported = **meshes_M[i];
    if (!imported.closed) {
      world.remarks.push_back(
          At(body, imported.diagnosis +
                       " (its surface is not closed: contact goes by what is there, its inside "
                       "and its mass are estimates; if it behaves oddly, mend the mesh)")
              .what);
    }
    for (const std::string& remark : imported.remarks) {
      world.remarks.push_back(At(body, remark).what);
    }
    world.meshes_W.push_back(std::move(imported.mesh));
    for (Vec3& vertex : world.meshes_W.back().vertices) vertex = body.X_WM * vertex;
    if (const auto remark = ScaleRemark(body, world.meshes_W.back())) {
      world.remarks.push_back(At(body, *remark).what);
    }
  }
  return std::nullopt;
}

std::optional<Error> LoadFixture(const Scene& scene, const TriangleMesh& fixture_W,
                                 const LoadOptions& options, WorldModel& world) {
  if (const auto fault = MakeFixture(fixture_W, world, options)) {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const SceneBody& body = scene.bodies[i];
      if (!body.fixed || !ScaleRemark(body, world.meshes_W[i])) continue;
      return At(body, WithScale(*fault, body, world.meshes_W[i]).what);
    }
    return Error{scene.file.string() + ": the fixed bodies: " + fault->what};
  }
  return std::nullopt;
}

std::size_t FirstFixed(const Scene& scene) {
  const auto found =
      std::find_if(scene.bodies.begin(), scene.bodies.end(), [](const SceneBody& body) {
        return body.fixed;
      });
  return static_cast<std::size_t>(found - scene.bodies.begin());
}

/// Loads the moving bodies and the fixture side by side: each has stages in which one thread works
/// alone.
std::optional<Error> LoadBodies(const Scene& scene, const LoadOptions& options, WorldModel& world) {
  const auto fixed = static_cast<std::size_t>(
      std::count_if(scene.bodies.begin(), scene.bodies.end(), [](const SceneBody& body) {
        return body.fixed;
      }));
  // usually large, and most often a single mesh: then it is not copied
  const std::size_t only = fixed == 1 ? FirstFixed(scene) : 0;
  const TriangleMesh merged_W = fixed > 1 ? FixtureOf(scene, world.meshes_W) : TriangleMesh{};
  const TriangleMesh& fixture_W = fixed == 1 ? world.meshes_W[only] : merged_W;
  std::vector<std::uint32_t> moving;
  for (std::uint32_t i = 0; i < scene.bodies.size(); ++i) {
    if (!scene.bodies[i].fixed && scene.WholeOf(i) == i) moving.push_back(i);
  }
  if (moving.empty()) return Error{scene.file.string() + ": no body can move"};
  std::vector<std::optional<Result<BodyModel>>> models(moving.size());
  std::vector<std::vector<std::string>> remarks(moving.size());
  std::optional<Error> fixture_fault;
  // the fixture first: it is usually the largest
  tbb::parallel_for(std::size_t{0}, moving.size() + 1, [&](std::size_t i) {
    if (options.stop.stop_requested()) return;
    if (i > 0) {
      const std::uint32_t body = moving[i - 1];
      models[i - 1] = LoadBody(scene, scene.bodies[body], WholeOf(scene, world.meshes_W, body),
                               moving.size() > 1, options, remarks[i - 1]);
    } else if (!fixture_W.triangles.empty()) {
      fixture_fault = LoadFixture(scene, fixture_W, options, world);
    }
  });
  if (options.stop.stop_requested()) return Stopped(scene);
  world.body_index.assign(scene.bodies.size(), -1);
  for (std::size_t k = 0; k < moving.size(); ++k) {
    const SceneBody& body = scene.bodies[moving[k]];
    Result<BodyModel>& model = *models[k];
    if (!model) return model.error();
    world.remarks.insert(world.remarks.end(), remarks[k].begin(), remarks[k].end());
    if (body.inward_shift_voxels != 0) {
      if (const auto gap = GapRemark(scene, *model, 0)) {
        world.remarks.push_back(At(body, *gap).what);
      }
    }
    world.body_index[moving[k]] = static_cast<int>(k);
    world.bodies.push_back(std::move(*model));
    world.object.push_back(moving[k]);
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    world.body_index[i] = world.body_index[scene.WholeOf(i)];
  }
  return fixture_fault;
}

}  // namespace

TriangleMesh MeshOfBody(const WorldModel& world, std::size_t body) {
  TriangleMesh mesh_W;
  for (std::size_t i = 0; i < world.meshes_W.size(); ++i) {
    if (world.body_index[i] == static_cast<int>(body)) Append(mesh_W, world.meshes_W[i]);
  }
  return mesh_W;
}

std::size_t TestedPoints(const WorldModel& world, const BodyModel& body) {
  const bool refined = world.scene.contact == ContactModel::kRefined;
  return refined ? body.surface.features.point_count() : body.points.size();
}

std::size_t FixtureVoxels(const WorldModel& world) {
  if (world.fixture_pages != nullptr) return world.fixture_pages->counts().total();
  return ReadVoxels(world, world.fixture, world.fixture_surface);
}

std::size_t ReadVoxels(const WorldModel& world, const Voxmap& voxmap, const BodySurface& surface) {
  const bool refined = world.scene.contact == ContactModel::kRefined;
  return refined ? kCellsPerBrick * surface.field.Count().bricks : voxmap.Count().total();
}

std::optional<Error> AddPlainParts(WorldModel& world) {
  const Scene& scene = world.scene;
  if (world.has_fixture) {
    const TriangleMesh fixture_W = FixtureOf(scene, world.meshes_W);
    if (auto fault = MakeMap(scene, fixture_W, world.fixture)) return fault;
  }
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    const SceneBody& body = scene.bodies[world.object[b]];
    if (auto fault = MakePlainParts(scene, body, MeshOfBody(world, b), world.bodies.size() > 1, {},
                                    world.bodies[b])) {
      return At(body, fault->what);
    }
  }
  return std::nullopt;
}

std::optional<std::string> GapRemark(const Scene& scene, const BodyModel& body,
                                     double displacement) {
  // a hundredth of a voxel more lets nothing through that a voxel stops
  constexpr double kToTell = 1.01;  // voxels
  if (scene.contact == ContactModel::kRefined) return std::nullopt;
  const double gap = body.points.GapWhenDisplaced(displacement);
  if (gap <= kToTell * scene.voxel_size) return std::nullopt;
  char text[160];
  std::snprintf(text, sizeof text,
                "its displaced points stand up to %.2f voxels apart: what is thinner may slip "
                "between them; displace them less",
                gap / scene.voxel_size);
  return text;
}

std::optional<Error> MakeShape(const Scene& scene, const SceneBody& body,
                               const TriangleMesh& mesh_W, bool with_voxmap, BodyModel& model,
                               const LoadOptions& options) {
  if (scene.contact == ContactModel::kRefined) {
    const double spacing = body.point_spacing_voxels;
    Result<BodySurface> surface = MakeSurface(scene, mesh_W, model.X_WB0, spacing, options);
    if (!surface) return surface.error();
    model.surface = std::move(*surface);
    const DistanceField& field = model.surface.field;
    model.surface.rounds =
        FindRoundFeatures(mesh_W, field.p_WVo(), field.voxel_size(), model.surface.features);
    model.radius = model.surface.radius;
    model.surface_points = PointsOnSurface(scene, mesh_W, spacing);
    return std::nullopt;
  }
  if (auto fault = MakePlainParts(scene, body, mesh_W, with_voxmap, options, model)) {
    return fault;
  }
  model.radius = model.points.radius;
  model.surface_points = static_cast<double>(model.points.size());
  return std::nullopt;
}

namespace {

VoxelizeOptions VoxelizeOptionsOf(const Scene& scene, const LoadOptions& load) {
  return {.voxel_size = scene.voxel_size,
          .range = scene.range_voxels,
          .bits = BitsFor(scene.range_voxels),
          .flatness_voxels = FlatnessVoxels(scene.contact),
          .stop = load.stop};
}

/// Opens the fixed bodies' voxels, to be read when they are needed unless all of them fit.
std::optional<Error> OpenPages(const TriangleMesh& mesh_W, WorldModel& world,
                               const LoadOptions& load) {
  const VoxelizeOptions whole = VoxelizeOptionsOf(world.scene, load);
  VoxelizeOptions options = whole;
  constexpr std::uint64_t kEnough = std::uint64_t{2}
                                    << 30U;  // enough that there are not too many parts
  options.max_memory_bytes =
      std::min<std::uint64_t>(options.max_memory_bytes, std::max(kEnough, load.voxel_memory_bytes));
  Result<std::shared_ptr<const PageSource>> pages =
      load.cache != nullptr ? load.cache->PagesOf(mesh_W, options) : ComputePages(mesh_W, whole);
  if (!pages) return pages.error();
  if ((*pages)->counts().bytes <= load.voxel_memory_bytes) {
    return MakeMap(world.scene, mesh_W, world.fixture, load);
  }
  if (auto fault = ResidentVoxels::BudgetFault(**pages, load.voxel_memory_bytes)) return fault;
  world.fixture_pages = std::move(*pages);
  if (load.disk_bytes_per_s > 0) {
    world.fixture_pages =
        std::make_shared<const SlowPages>(std::move(world.fixture_pages), load.disk_bytes_per_s);
  }
  world.voxel_memory_bytes = load.voxel_memory_bytes;
  return std::nullopt;
}

}  // namespace

std::optional<Error> MakeFixture(const TriangleMesh& mesh_W, WorldModel& world,
                                 const LoadOptions& options) {
  if (world.scene.contact == ContactModel::kRefined) {
    Result<BodySurface> surface = MakeSurface(world.scene, mesh_W, Pose{}, 1, options);
    if (!surface) return surface.error();
    world.fixture_surface = std::move(*surface);
    world.fixture_surface.radius = 0;  // it never moves
  } else if (options.voxel_memory_bytes > 0) {
    if (auto fault = OpenPages(mesh_W, world, options)) return fault;
  } else if (auto fault = MakeMap(world.scene, mesh_W, world.fixture, options)) {
    return fault;
  }
  world.has_fixture = true;
  return std::nullopt;
}

std::optional<Error> MakeMap(const Scene& scene, const TriangleMesh& mesh_W, Voxmap& voxmap,
                             const LoadOptions& load) {
  const VoxelizeOptions options = VoxelizeOptionsOf(scene, load);
  Result<Voxmap> made =
      load.cache != nullptr ? load.cache->VoxmapOf(mesh_W, options) : Voxelize(mesh_W, options);
  if (!made) return made.error();
  voxmap = std::move(*made);
  return std::nullopt;
}

Result<BodySurface> MakeSurface(const Scene& scene, const TriangleMesh& mesh_W, const Pose& X_WB,
                                double spacing_voxels, const LoadOptions& options) {
  const SurfaceOptions of_surface{.voxel_size = scene.voxel_size,
                                  .flatness_voxels = FlatnessVoxels(scene.contact),
                                  .spacing_voxels = spacing_voxels,
                                  .band_voxels = scene.fine_band_voxels,
                                  .range_voxels = scene.clearance_range_voxels,
                                  .stop = options.stop};
  return options.cache != nullptr ? options.cache->SurfaceOf(mesh_W, X_WB, of_surface)
                                  : BuildSurface(mesh_W, X_WB, of_surface);
}

Result<Pointshell> MakePoints(const Scene& scene, const TriangleMesh& mesh_W, const Pose& X_WB,
                              double inward_shift_voxels, double spacing_voxels,
                              const LoadOptions& load) {
  const bool refined = scene.contact == ContactModel::kRefined;
  const PointshellOptions options{
      .spacing = spacing_voxels * scene.voxel_size,
      .inward_shift = inward_shift_voxels * scene.voxel_size,
      .place = refined ? PointPlace::kOnFeature : PointPlace::kVoxelCentre,
      .flatness_voxels = FlatnessVoxels(scene.contact),
      .most_displacement = scene.voxel_size};
  return load.cache != nullptr ? load.cache->PointsOf(mesh_W, X_WB, options)
                               : MakePointshell(mesh_W, X_WB, options);
}

Result<std::shared_ptr<const WorldModel>> LoadWorld(const Scene& scene,
                                                    const LoadOptions& options) {
  if (const std::string fault = LayerFault(scene.contact, scene.force_layer); !fault.empty()) {
    return Error{scene.file.string() + ": " + fault};
  }
  if (options.voxel_memory_bytes > 0 && scene.contact != ContactModel::kPlain) {
    return Error{scene.file.string() +
                 ": a limit of the voxels' memory needs the contact model plain; this scene's is "
                 "refined"};
  }
  auto world = std::make_shared<WorldModel>();
  world->scene = scene;
  if (auto fault = LoadMeshes(scene, options, *world)) return *fault;
  if (auto fault = LoadBodies(scene, options, *world)) return *fault;
  return std::shared_ptr<const WorldModel>(std::move(world));
}

}  // namespace tandem
