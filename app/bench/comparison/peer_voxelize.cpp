#include <cstdio>

#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/global_control.h>

#include "app/bench/comparison/peer_support.h"
#include "app/common/scene_files.h"
#include "engine/geometry/import/mesh_file.h"
#include "engine/voxel/build/voxelize.h"

// Times Voxelize (three distance fields, interior) beside OpenVDB's meshToVolume (one unsigned
// field), both to eight voxels from the surface.
namespace tandem {
namespace {

constexpr float kHalfWidth = 8;

struct Arguments {
  std::filesystem::path file;
  double scale = 0.001;
  double voxel = 0.001;
  std::size_t threads = 4;
};

std::optional<Error> Run(const Arguments& arguments) {
  const Result<TriangleMesh> mesh =
      ImportAndTell(arguments.file, {.scale = arguments.scale, .seconds_limit = 60});
  if (!mesh) return mesh.error();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, arguments.threads);

  Result<Voxmap> voxmap = Voxmap();
  const Timed ours = Repeated([&] {
    voxmap = Voxelize(*mesh, {.voxel_size = arguments.voxel});
  });
  if (!voxmap) return voxmap.error();
  const VoxelCounts counts = voxmap->Count();

  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  const auto transform = openvdb::math::Transform::createLinearTransform(arguments.voxel);
  for (const Vec3& v : mesh->vertices) points.emplace_back(v.x(), v.y(), v.z());
  for (const auto& t : mesh->triangles) triangles.emplace_back(t[0], t[1], t[2]);
  std::size_t active = 0;
  std::size_t bytes = 0;
  const Timed theirs = Repeated([&] {
    const auto grid = openvdb::tools::meshToUnsignedDistanceField<openvdb::FloatGrid>(
        *transform, points, triangles, quads, kHalfWidth);
    active = grid->activeVoxelCount();
    bytes = grid->memUsage();
  });

  const auto timed = [](const Timed& t) {
    return nlohmann::ordered_json{{"cpu_s", t.cpu_s}, {"wall_s", t.wall_s}, {"runs", t.runs}};
  };
  nlohmann::ordered_json out{{"file", arguments.file.filename()},
                             {"triangles", mesh->triangles.size()},
                             {"voxel_m", arguments.voxel},
                             {"threads", arguments.threads},
                             {"tandem", timed(ours)},
                             {"openvdb", timed(theirs)},
                             {"cpu_ratio", theirs.cpu_s / ours.cpu_s},
                             {"wall_ratio", theirs.wall_s / ours.wall_s}};
  out["tandem"].update({{"band_voxels", counts.total()}, {"bytes", counts.bytes}});
  out["openvdb"].update({{"active_voxels", active}, {"bytes", bytes}});
  std::printf("%s\n", out.dump(2).c_str());
  return std::nullopt;
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  tandem::RunImportHelperIfAsked(argc, argv);
  openvdb::initialize();
  tandem::Arguments arguments;
  CLI::App app{"Measure voxelization beside OpenVDB's meshToVolume; print JSON"};
  app.add_option("file", arguments.file, "mesh file to voxelize")->required();
  app.add_option("--scale", arguments.scale, "metres per file unit")->capture_default_str();
  app.add_option("--voxel", arguments.voxel, "voxel size, m")->capture_default_str();
  app.add_option("--threads", arguments.threads, "number of threads for both")
      ->capture_default_str();
  return tandem::RunPeer(app, argc, argv, [&] {
    return tandem::Run(arguments);
  });
}
