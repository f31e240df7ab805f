#include "engine/voxel/build/voxelize.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "engine/geometry/mesh/facets.h"
#include "engine/geometry/mesh/mesh_facing.h"
#include "engine/voxel/build/inside_winding.h"
#include "engine/voxel/build/mark_source.h"
#include "engine/voxel/build/voxmap_builder.h"

namespace tandem {

namespace {

constexpr double kFarthestVoxel =
    1 << 22;  // distance from W's origin that keeps indices and codes in range

constexpr double kShareBeforeMarks = 0.5;  // share of the work

double Area(const TriangleMesh& mesh) {
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 1) - mesh.corner(t, 0);
    const Vec3 b = mesh.corner(t, 2) - mesh.corner(t, 0);
    area += 0.5 * a.cross(b).norm();
  }
  return area;
}

std::size_t NeededBytes(const Bounds& box, double area, std::size_t triangles, double voxel_size,
                        int range, int bits) {
  // per voxel size squared of area: the planes of three fields and the rows of bits they come from;
  // per triangle: its sides, facet, snapped corners and bins; per hyperchunk of the box its numbers
  const Vec3 size = box.size() / voxel_size + Vec3::Constant(256.0);
  const double squares = area / (voxel_size * voxel_size);
  const double hyperchunks = size.prod() / std::pow(kHyperchunkSide, 3);
  double marks = 65.0 * squares;
  if (bits == 8) {
    // all that the range reaches, and a bit a voxel for each round of growth
    const double voxels = (box.size() / voxel_size + Vec3::Constant(2.0 * range + 64)).prod();
    const double rounds = static_cast<double>(MarkPlanes::Rounds(range)) - 1;
    marks += kFields * voxels * (1.0 + rounds / 8);
  }
  const double bytes = marks + 150.0 * static_cast<double>(triangles) + 40.0 * hyperchunks + 3e7;
  return bytes < 1e18 ? static_cast<std::size_t>(bytes) : std::size_t{1} << 60U;
}

std::string InGiB(std::size_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g GiB",
                static_cast<double>(bytes) / static_cast<double>(1ULL << 30U));
  return text;
}

/// Returns why these options are impossible, whatever the mesh.
std::optional<Error> OptionsFault(const VoxelizeOptions& options) {
  const int greatest = WidestRange(options.bits);
  if (options.bits != 2 && options.bits != 4 && options.bits != 8) {
    return Error{"marks have 2, 4 or 8 bits, not " + std::to_string(options.bits)};
  }
  if (options.range < 1 || options.range > greatest) {
    return Error{"marks of " + std::to_string(options.bits) + " bits hold distances of 1 to " +
                 std::to_string(greatest) + " voxels, not " + std::to_string(options.range)};
  }
  return std::nullopt;
}

}  // namespace

std::size_t EstimateVoxelizeBytes(const TriangleMesh& mesh_W, const VoxelizeOptions& options) {
  return NeededBytes(BoundsOf(mesh_W), Area(mesh_W), mesh_W.triangles.size(), options.voxel_size,
                     options.range, options.bits);
}

double AutoVoxelSize(const TriangleMesh& mesh) {
  return BoundsOf(mesh).size().maxCoeff() / 200.0;
}

std::optional<Error> VoxelSizeFault(const TriangleMesh& mesh_W, const VoxelizeOptions& options) {
  const double s = options.voxel_size;
  const std::size_t max_memory_bytes = options.max_memory_bytes;
  if (mesh_W.triangles.empty()) return Error{"the mesh has no triangles"};
  if (!(s > 0) || !std::isfinite(s)) return Error{"the voxel size must be above 0 m"};
  const Bounds box = BoundsOf(mesh_W);
  const double area = Area(mesh_W);
  const std::size_t triangles = mesh_W.triangles.size();
  const auto needed = [&](double voxel_size) {
    return NeededBytes(box, area, triangles, voxel_size, options.range, options.bits);
  };
  const std::size_t need = needed(s);
  const double farthest = std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
  if (need <= max_memory_bytes && farthest <= kFarthestVoxel * s) return std::nullopt;
  // the need falls with the square of the voxel size, or faster
  double fits = std::max(s, farthest / kFarthestVoxel);
  while (needed(fits) > max_memory_bytes && fits < 1e6) fits *= 1.05;
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

std::optional<Error> VoxelizeFault(const TriangleMesh& mesh_W, const VoxelizeOptions& options) {
  if (std::optional<Error> fault = OptionsFault(options)) return fault;
  return VoxelSizeFault(mesh_W, options);
}

namespace {

/// A mesh as it is voxelized, some layers of hyperchunks at a time.
struct Task {
  const TriangleMesh& mesh_W;
  const Features& features;
  const MeshFacing& facing;
  const VoxelizeOptions& options;
  /// Gets the share that is done; rises from 0 to 1 in each call of VoxelizeLayers().
  std::function<void(double)> tell;
};

/// Makes the map of a mesh with the voxels of some layers alone: with its whole box, and a
/// chunk-level field that covers no others.
Result<Voxmap> VoxelizeLayers(const Task& task, const HyperchunkLayers& layers);

/// Voxelizes a mesh that fits, with valid options.
Result<Voxmap> VoxelizeFitting(const TriangleMesh& mesh_W, const MeshSides& sides,
                               const Features& features, const VoxelizeOptions& options) {
  const auto tell = [&options](double share) {
    if (options.progress) options.progress(share);
  };
  tell(0.0);
  const MeshFacing facing = FindFacing(mesh_W, sides);
  if (auto fault = WindingCostFault(mesh_W, facing, options.voxel_size)) return *std::move(fault);
  return VoxelizeLayers({mesh_W, features, facing, options, tell}, {});
}

}  // namespace

Result<Voxmap> Voxelize(const TriangleMesh& mesh_W, const VoxelizeOptions& options) {
  if (std::optional<Error> fault = VoxelizeFault(mesh_W, options)) return *fault;
  const MeshSides sides(mesh_W);
  return VoxelizeFitting(mesh_W, sides,
                         FindFeatures(mesh_W, sides, options.flatness_voxels * options.voxel_size),
                         options);
}

std::optional<Error> VoxelizeInParts(
    const TriangleMesh& mesh_W, const VoxelizeOptions& options,
    const std::function<std::optional<Error>(const Voxmap& part)>& take) {
  if (std::optional<Error> fault = OptionsFault(options)) return fault;
  const double side = kHyperchunkSide * options.voxel_size;
  const Bounds box = BoundsOf(mesh_W);
  const double layers = mesh_W.triangles.empty() ? 1.0 : std::floor(box.size().z() / side) + 3.0;
  // memory that does not depend on the voxels is needed for each part
  const std::size_t least =
      NeededBytes(box, 0, mesh_W.triangles.size(), options.voxel_size, options.range, options.bits);
  const std::size_t all = EstimateVoxelizeBytes(mesh_W, options);
  double parts = 1;
  if (all > options.max_memory_bytes && options.max_memory_bytes > least && options.bits != 8) {
    // includes the layers on both sides of a part
    parts = std::ceil(static_cast<double>(all - least) /
                      static_cast<double>(options.max_memory_bytes - least));
    parts = std::clamp(parts, 1.0, std::max(1.0, std::floor(layers / 2.0)));
  }
  VoxelizeOptions of_part = options;
  if (parts > 1) of_part.max_memory_bytes = all;
  if (std::optional<Error> fault = VoxelSizeFault(mesh_W, of_part)) return fault;
  const MeshSides sides(mesh_W);
  const Features features =
      FindFeatures(mesh_W, sides, options.flatness_voxels * options.voxel_size);
  const MeshFacing facing = FindFacing(mesh_W, sides);
  if (auto fault = WindingCostFault(mesh_W, facing, options.voxel_size)) return fault;
  const auto first = static_cast<std::int32_t>(std::floor(box.min.z() / side)) - 1;
  for (double part = 0; part < parts; ++part) {
    const auto border = [&](double number) {
      return first + static_cast<std::int32_t>(std::floor(layers * number / parts));
    };
    const Task task{mesh_W, features, facing, options, [&](double share) {
                      if (options.progress) options.progress((part + share) / parts);
                    }};
    const Result<Voxmap> made = VoxelizeLayers(
        task,
        {part > 0 ? border(part) : INT32_MIN, part + 1 < parts ? border(part + 1) : INT32_MAX});
    if (!made) return made.error();
    if (std::optional<Error> fault = take(*made)) return fault;
  }
  return std::nullopt;
}

Result<Voxmap> Voxelize(const TriangleMesh& mesh_W, const MeshSides& sides,
                        const Features& features, const VoxelizeOptions& options) {
  if (std::optional<Error> fault = VoxelizeFault(mesh_W, options)) return *fault;
  return VoxelizeFitting(mesh_W, sides, features, options);
}

namespace {

Result<Voxmap> VoxelizeLayers(const Task& task, const HyperchunkLayers& layers) {
  const VoxelizeOptions& options = task.options;
  const auto source = MarkSource::Make(task.mesh_W, task.features, task.facing, options, layers,
                                       [&task](double share) {
                                         task.tell(kShareBeforeMarks * share);
                                       });
  if (!source) return source.error();
  VoxmapBuilder builder(options.voxel_size, options.range, options.bits, (*source)->box(),
                        (*source)->kinds());
  std::uint64_t band_voxels = 0;
  std::size_t done = 0;
  const auto count = static_cast<double>((*source)->marked().size());
  const auto fault = (*source)->MakeAll([&](const GridIndex& place, const MarkPlanes& planes) {
    builder.Add(place, planes.record(), planes.planes());
    band_voxels += planes.band_voxels();
    task.tell(kShareBeforeMarks + (1 - kShareBeforeMarks) * static_cast<double>(++done) / count);
  });
  if (fault) return *fault;
  return builder.Finish(band_voxels);
}

}  // namespace

}  // namespace tandem
