#include <bit>
#include <cmath>
#include <cstdio>
#include <numeric>

#include <openvdb/openvdb.h>
#include <openvdb/tools/GridOperators.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>

#include "app/bench/comparison/peer_support.h"
#include "engine/contact/schedule/voxmap_lookup.h"
#include "engine/field/build/field_builder.h"
#include "engine/geometry/import/mesh_file.h"

// Times a pointshell's test beside OpenVDB's accessor, and a distance with gradient beside its
// BoxSampler: the same points by the same transforms, one thread, each with a map of its own kind
// of the same mesh at the same voxel size.
namespace tandem {
namespace {

struct OpenVdbMesh {
  std::vector<openvdb::Vec3s> vertices;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;  // none
  openvdb::math::Transform::Ptr to_world;
};

/// Returns a mesh for OpenVDB. Its voxels are counted from W's origin, and its values stand at
/// their corners: half a voxel aside they stand at the centres of ours.
OpenVdbMesh ForOpenVdb(const TriangleMesh& mesh, double s) {
  OpenVdbMesh out;
  for (const Vec3& v : mesh.vertices) out.vertices.emplace_back(v.x(), v.y(), v.z());
  for (const auto& t : mesh.triangles) out.triangles.emplace_back(t[0], t[1], t[2]);
  out.to_world = openvdb::math::Transform::createLinearTransform(s);
  out.to_world->postTranslate(openvdb::Vec3d(0.5 * s));
  return out;
}

/// Compares distance and gradient at all points that are within a voxel of the surface at any of
/// the poses: ours beside a level set and its gradients, each sampled trilinearly.
Result<nlohmann::ordered_json> CompareGradients(const PeerModels& models) {
  const double s = models.voxmap.voxel_size();
  const Result<DistanceField> field = BuildField(models.fixed, {.voxel_size = s});
  if (!field) return field.error();
  const OpenVdbMesh mesh = ForOpenVdb(models.fixed, s);
  const auto values = openvdb::tools::meshToSignedDistanceField<openvdb::FloatGrid>(
      *mesh.to_world, mesh.vertices, mesh.triangles, mesh.quads, 3, 3);
  const openvdb::Vec3SGrid::Ptr gradients = openvdb::tools::gradient(*values);

  std::vector<Vec3> places_V;
  std::vector<openvdb::Vec3d> places_I;
  for (const FilePose& pose : models.poses) {
    const Pose X_WB = pose.X_WM * models.X_MB;
    for (std::size_t i = 0; i < models.points.size(); ++i) {
      const Vec3 p_W = X_WB * Vec3(models.points.x[i], models.points.y[i], models.points.z[i]);
      const Vec3 place_V = (p_W - field->p_WVo()) / s;
      const FieldReading reading = field->At(place_V);
      if (!reading.near || std::abs(reading.value) > 1) continue;
      places_V.push_back(place_V);
      places_I.push_back(mesh.to_world->worldToIndex({p_W.x(), p_W.y(), p_W.z()}));
    }
  }
  if (places_V.empty()) return Error{"no point of these poses is near the surface"};
  const auto count = static_cast<double>(places_V.size());
  std::vector<FieldGradient> ours(places_V.size());
  const double tandem_ns = 1e9 / count * Repeated([&] {
                                           field->WithGradients(places_V, ours.data());
                                         }).cpu_s;
  auto value_at = values->getConstAccessor();
  auto gradient_at = gradients->getConstAccessor();
  std::vector<float> their_values(places_V.size());
  std::vector<openvdb::Vec3s> their_gradients(places_V.size());
  const double openvdb_ns =
      1e9 / count *
      Repeated([&] {
        for (std::size_t i = 0; i < places_I.size(); ++i) {
          openvdb::tools::BoxSampler::sample(value_at, places_I[i], their_values[i]);
          openvdb::tools::BoxSampler::sample(gradient_at, places_I[i], their_gradients[i]);
        }
      }).cpu_s;
  std::vector<double> apart;
  for (std::size_t i = 0; i < places_V.size(); ++i) {
    apart.push_back(std::abs(ours[i].reading.value - their_values[i] / s));
  }
  return nlohmann::ordered_json{{"places", places_V.size()},
                                {"tandem_ns", tandem_ns},
                                {"openvdb_box_sampler_ns", openvdb_ns},
                                {"ratio", openvdb_ns / tandem_ns},
                                {"apart_voxels_p50", MedianOf(apart)}};
}

std::optional<Error> Run(const PeerPair& pair) {
  const Result<PeerModels> models = LoadPeerModels(pair, ContactModel::kPlain);
  if (!models) return models.error();
  const Voxmap& voxmap = models->voxmap;
  const double s = voxmap.voxel_size();

  const OpenVdbMesh mesh = ForOpenVdb(models->fixed, s);
  const auto grid = openvdb::tools::meshToUnsignedDistanceField<openvdb::FloatGrid>(
      *mesh.to_world, mesh.vertices, mesh.triangles, mesh.quads, 8);

  const PointBlocks blocks(models->points);
  std::vector<std::uint32_t> all(blocks.size());
  std::iota(all.begin(), all.end(), 0U);
  std::vector<BlockReading> readings(blocks.size());
  std::vector<std::uint8_t> near(models->points.size());
  const auto points = static_cast<double>(models->points.size());
  const Pose X_VW{Quat::Identity(), -voxmap.p_WVo()};
  constexpr int kThreshold = 3;

  std::vector<double> tandem_ns;
  std::vector<double> openvdb_ns;
  std::size_t near_tandem = 0;
  std::size_t near_openvdb = 0;
  const double share = 2.0 / static_cast<double>(models->poses.size());
  for (const FilePose& pose : models->poses) {
    const Pose X_WB = pose.X_WM * models->X_MB;
    const VoxelTransform ours(X_VW * X_WB, s, 0);
    tandem_ns.push_back(1e9 / points *
                        Repeated(
                            [&] {
                              TestBlocks(blocks, ours, voxmap, kThreshold, all, readings.data());
                            },
                            share)
                            .cpu_s);
    for (const BlockReading& reading : readings) {
      near_tandem += static_cast<std::size_t>(std::popcount(reading.contacts));
    }

    const VoxelTransform theirs(X_WB, s, 0);
    auto accessor = grid->getConstAccessor();
    const auto limit = static_cast<float>((kThreshold - 2 + 0.5) * s);
    openvdb_ns.push_back(1e9 / points *
                         Repeated(
                             [&] {
                               const auto& a = theirs.a;
                               const auto& b = theirs.b;
                               for (std::size_t i = 0; i < near.size(); ++i) {
                                 const float x = models->points.x[i];
                                 const float y = models->points.y[i];
                                 const float z = models->points.z[i];
                                 const GridIndex at =
                                     VoxelAt({a[0] * x + a[1] * y + a[2] * z + b[0],
                                              a[3] * x + a[4] * y + a[5] * z + b[1],
                                              a[6] * x + a[7] * y + a[8] * z + b[2]});
                                 near[i] = accessor.getValue({at.x, at.y, at.z}) <= limit ? 1 : 0;
                               }
                             },
                             share)
                             .cpu_s);
    near_openvdb += static_cast<std::size_t>(std::accumulate(near.begin(), near.end(), 0));
  }
  const Result<nlohmann::ordered_json> gradients = CompareGradients(*models);
  if (!gradients) return gradients.error();
  const nlohmann::ordered_json out{{"fixed", pair.fixed.filename()},
                                   {"moving", pair.moving.filename()},
                                   {"voxel_m", s},
                                   {"points", models->points.size()},
                                   {"poses", models->poses.size()},
                                   {"map_bytes", voxmap.header().bytes},
                                   {"openvdb_bytes", grid->memUsage()},
                                   {"isa", KernelIsa()},
                                   {"tandem_ns", MedianOf(tandem_ns)},
                                   {"openvdb_ns", MedianOf(openvdb_ns)},
                                   {"ratio", MedianOf(openvdb_ns) / MedianOf(tandem_ns)},
                                   {"tandem_contacts", near_tandem},
                                   {"openvdb_near", near_openvdb},
                                   {"with_gradient", *gradients}};
  std::printf("%s\n", out.dump(2).c_str());
  return std::nullopt;
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  tandem::RunImportHelperIfAsked(argc, argv);
  openvdb::initialize();
  tandem::PeerPair pair;
  CLI::App app{"Measure point tests beside OpenVDB's accessor; print JSON"};
  tandem::AddPeerPair(app, pair);
  return tandem::RunPeer(app, argc, argv, [&] {
    return tandem::Run(pair);
  });
}
