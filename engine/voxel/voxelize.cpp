#include "engine/voxel/voxelize.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <string>

#include <tbb/parallel_for.h>

#include "engine/voxel/distance_field.h"
#include "engine/voxel/ray_parity.h"
#include "engine/voxel/surface_voxels.h"

namespace tandem {

namespace {

constexpr double kFarthestVoxel =
    1 << 22;  // from W's origin, so that indices and codes stay in range

double Area(const TriangleMesh& mesh) {
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 1) - mesh.corner(t, 0);
    const Vec3 b = mesh.corner(t, 2) - mesh.corner(t, 0);
    area += 0.5 * a.cross(b).norm();
  }
  return area;
}

struct ByPlace {
  bool operator()(const GridIndex& a, const GridIndex& b) const {
    return MortonCode(a) < MortonCode(b);
  }
};

/// The hyperchunks that the surface or its band may reach into.
std::set<GridIndex, ByPlace> BandHyperchunks(const SurfaceVoxels& surface, int range) {
  const std::int32_t reach = (range + kChunkSide - 1) / kChunkSide;  // chunks
  std::set<GridIndex, ByPlace> places;
  for (const SurfaceVoxels::Chunk& chunk : surface.chunks) {
    const GridIndex lowest = (chunk.place - GridIndex{reach, reach, reach}) >> 3;
    const GridIndex highest = (chunk.place + GridIndex{reach, reach, reach}) >> 3;
    for (std::int32_t z = lowest.z; z <= highest.z; ++z) {
      for (std::int32_t y = lowest.y; y <= highest.y; ++y) {
        for (std::int32_t x = lowest.x; x <= highest.x; ++x) places.insert({x, y, z});
      }
    }
  }
  return places;
}

/// The marks of a hyperchunk: three distance fields, and the inside in the surface field.
HyperchunkMarks FillHyperchunk(const FeatureVoxels& features, const RayParity& parity,
                               const GridIndex& place, int range) {
  HyperchunkMarks out;
  out.place = place;
  for (const Field field : kAllFields) {
    FillDistances(features[field], place, range, out.marks[static_cast<std::size_t>(field)]);
  }
  std::vector<Mark>& marks = out.marks[0];
  std::vector<std::uint8_t> votes(marks.size(), 0);
  parity.AddVotes(place * kHyperchunkSide, kHyperchunkSide, votes);
  for (std::size_t i = 0; i < votes.size(); ++i) {
    if (votes[i] >= 2 && marks[i] != kSurfaceMark) marks[i] = kInteriorMark;
  }
  return out;
}

std::string InGiB(std::size_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g GiB",
                static_cast<double>(bytes) / static_cast<double>(1ULL << 30U));
  return text;
}

}  // namespace

std::size_t EstimateVoxelizeBytes(const TriangleMesh& mesh_W, double voxel_size) {
  // per voxel size squared of area: 4.5/64 chunks of 256 bytes and as much again while they are
  // copied, 1.5 ray crossings of 24 bytes and their sort; per column of the box's sides one 4-byte
  // number, and per hyperchunk of the box one
  const Vec3 size = BoundsOf(mesh_W).size() / voxel_size + Vec3::Constant(128.0);
  const double area = Area(mesh_W) / (voxel_size * voxel_size);
  const double sides = size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
  const double hyperchunks = size.prod() / std::pow(kHyperchunkSide, 3);
  const double bytes = 110.0 * area + 4.0 * sides + 4.0 * hyperchunks + 3e7;
  return bytes < 1e18 ? static_cast<std::size_t>(bytes) : std::size_t{1} << 60U;
}

double AutoVoxelSize(const TriangleMesh& mesh) {
  return BoundsOf(mesh).size().maxCoeff() / 200.0;
}

std::optional<Error> VoxelSizeFault(const TriangleMesh& mesh_W, double voxel_size,
                                    std::size_t max_memory_bytes) {
  const double s = voxel_size;
  if (mesh_W.triangles.empty()) return Error{"the mesh has no triangles"};
  if (!(s > 0) || !std::isfinite(s)) return Error{"the voxel size must be above 0 m"};
  const std::size_t need = EstimateVoxelizeBytes(mesh_W, s);
  const Bounds box = BoundsOf(mesh_W);
  const double farthest = std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
  if (need <= max_memory_bytes && farthest <= kFarthestVoxel * s) return std::nullopt;
  // the need falls with the square of the voxel size, or faster
  double fits = std::max(s, farthest / kFarthestVoxel);
  while (EstimateVoxelizeBytes(mesh_W, fits) > max_memory_bytes && fits < 1e6) fits *= 1.05;
  char text[200];
  if (fits >= 1e6) {
    std::snprintf(text, sizeof text, "no voxel size fits into %s", InGiB(max_memory_bytes).c_str());
  } else if (need <= max_memory_bytes) {
    std::snprintf(text, sizeof text,
                  "voxels of %g m are too small for a mesh %g m from the origin; %.2g m would do",
                  s, farthest, 1.05 * fits);
  } else {
    std::snprintf(text, sizeof text,
                  "voxels of %g m would need about %s of memory, more than the %s allowed; "
                  "%.2g m would fit",
                  s, InGiB(need).c_str(), InGiB(max_memory_bytes).c_str(), 1.05 * fits);
  }
  return Error{text};
}

Result<Voxmap> Voxelize(const TriangleMesh& mesh_W, const VoxelizeOptions& options) {
  const double s = options.voxel_size;
  if (std::optional<Error> fault = VoxelSizeFault(mesh_W, s, options.max_memory_bytes)) {
    return *fault;
  }

  const std::vector<SnappedTriangle> triangles = SnapTriangles(mesh_W, s);
  const Features features = FindFeatures(mesh_W, options.flatness_voxels * s);
  const FeatureVoxels voxels = FindFeatureVoxels(mesh_W, features, s);
  const RayParity parity(mesh_W, triangles);
  const std::set<GridIndex, ByPlace> band = BandHyperchunks(voxels.surface(), options.range);
  GridIndex lowest = *band.begin();
  GridIndex highest = lowest;
  for (const GridIndex& p : band) {
    lowest = {std::min(lowest.x, p.x), std::min(lowest.y, p.y), std::min(lowest.z, p.z)};
    highest = {std::max(highest.x, p.x), std::max(highest.y, p.y), std::max(highest.z, p.z)};
  }
  VoxmapBuilder builder(s, options.range, 4);

  // batches bound the memory of unpacked marks; within one, hyperchunks are filled in parallel
  const std::vector<GridIndex> places(band.begin(), band.end());
  constexpr std::size_t kBatch = 64;
  for (std::size_t begin = 0; begin < places.size(); begin += kBatch) {
    std::vector<HyperchunkMarks> filled(std::min(kBatch, places.size() - begin));
    tbb::parallel_for(std::size_t{0}, filled.size(), [&](std::size_t i) {
      filled[i] = FillHyperchunk(voxels, parity, places[begin + i], options.range);
    });
    for (const HyperchunkMarks& marks : filled) builder.Add(marks);
  }
  // hyperchunks without surface or band are solid or empty throughout
  for (std::int32_t z = lowest.z; z <= highest.z; ++z) {
    for (std::int32_t y = lowest.y; y <= highest.y; ++y) {
      for (std::int32_t x = lowest.x; x <= highest.x; ++x) {
        const GridIndex place{x, y, z};
        if (!band.contains(place) && parity.Inside(place * kHyperchunkSide)) {
          builder.Add({.place = place, .marks = {}, .solid = true});
        }
      }
    }
  }
  return builder.Finish();
}

}  // namespace tandem
