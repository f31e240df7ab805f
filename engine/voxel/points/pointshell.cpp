#include "engine/voxel/points/pointshell.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <tbb/parallel_for.h>

#include "engine/base/hash.h"
#include "engine/voxel/build/voxelize.h"
#include "engine/voxel/points/surface_voxels.h"
#include "engine/voxel/points/voxel_surface.h"

namespace tandem {

namespace {

/// A point on its way into a shell; lengths in voxels, axes of W.
struct ShellPoint {
  GridIndex voxel;
  Label label = Label::kSurface;
  Vec3 place = Vec3::Zero();   // from W's origin
  Vec3 inward = Vec3::Zero();  // unit normal
  Vec3 tangent = Vec3::Zero();
  double half_length = 0;
  double cosine = 0;
  bool ends = false;
};

/// Sorts points by label, the vertices first, and then by neighbourhood.
void Order(std::vector<ShellPoint>& points) {
  std::stable_sort(points.begin(), points.end(), [](const ShellPoint& a, const ShellPoint& b) {
    if (a.label != b.label) return a.label > b.label;
    return MortonCode(a.voxel) < MortonCode(b.voxel);
  });
}

Vec3 Centre(const GridIndex& voxel) {
  return Vec3(voxel.x, voxel.y, voxel.z) + Vec3::Constant(0.5);
}

using ChunkedPoints = std::vector<std::vector<ShellPoint>>;  // per chunk of SurfaceVoxels

/// Makes one point for each side of each surface voxel; on features, one more for each edge beside
/// a vertex or a longer edge.
ChunkedPoints SurfacePoints(const FeatureVoxels& voxels, const TriangleMesh& mesh_W,
                            const Features& features, PointPlace place) {
  const FeatureNormals normals = FindFeatureNormals(mesh_W, features);
  const std::vector<SurfaceVoxels::Chunk>& chunks = voxels.surface().chunks;
  ChunkedPoints made(chunks.size());
  tbb::parallel_for(std::size_t{0}, made.size(), [&](std::size_t c) {
    const auto add = [&](const VoxelSurface& surface) {
      ShellPoint point;
      point.voxel = chunks[c].place * kChunkSide + BlockCell(surface.cell);
      point.label = surface.label;
      point.place = place == PointPlace::kVoxelCentre
                        ? Centre(point.voxel)
                        : Vec3(point.voxel.x, point.voxel.y, point.voxel.z) + surface.place;
      point.tangent = surface.tangent;
      point.half_length = surface.half_length;
      point.ends = surface.ends;
      point.cosine = surface.cosine;
      for (std::size_t side = 0; side < surface.sides; ++side) {
        point.inward = place == PointPlace::kOnFeature && surface.sides == 1
                           ? -surface.feature_normal
                           : -surface.normals[side];
        made[c].push_back(point);
      }
    };
    const ChunkSurfaces surfaces = SurfacesOfChunk(voxels, chunks[c], mesh_W, features, normals);
    for (const VoxelSurface& surface : surfaces.voxels) add(surface);
    if (place == PointPlace::kOnFeature) {
      for (const VoxelSurface& edge : surfaces.more_edges) add(edge);
    }
    Order(made[c]);
  });
  return made;
}

/// Visits the points of one voxel among those of a chunk.
template <typename Visit>
void ForEachPointAt(const SurfaceVoxels& surface, const ChunkedPoints& points,
                    const GridIndex& voxel, const Visit& visit) {
  const auto chunk = surface.chunk_at.find(voxel >> 3);
  if (chunk == surface.chunk_at.end()) return;
  const std::size_t cell = CellInBlock(voxel);
  if ((surface.chunks[chunk->second].bits[cell >> 6] >> (cell & 63) & 1) == 0) return;
  for (const ShellPoint& point : points[chunk->second]) {
    if (point.voxel == voxel) visit(point);
  }
}

/// Makes the points of the k-th free layer: one in the middle of each voxel at chess-board distance
/// k outside the surface, with label and normal of the nearest surface voxel.
ChunkedPoints FreeLayerPoints(const SurfaceVoxels& surface, const ChunkedPoints& points, int k) {
  ChunkedPoints layer(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t c) {
    for (const ShellPoint& source : points[c]) {
      for (int z = -k; z <= k; ++z) {
        for (int y = -k; y <= k; ++y) {
          const bool rim = std::abs(z) == k || std::abs(y) == k;
          for (int x = -k; x <= k; x += rim ? 1 : 2 * k) {
            const GridIndex voxel = source.voxel + GridIndex{x, y, z};
            // the source must be its nearest surface voxel, by the rank of the offset among equals
            const ShellPoint* nearest = nullptr;
            double least = std::numeric_limits<double>::infinity();
            for (int n = 0; n < (2 * k + 1) * (2 * k + 1) * (2 * k + 1); ++n) {
              const int side = 2 * k + 1;
              const GridIndex other =
                  voxel + GridIndex{n % side - k, n / side % side - k, n / (side * side) - k};
              ForEachPointAt(surface, points, other, [&](const ShellPoint& point) {
                const double square = (Centre(voxel) - Centre(point.voxel)).squaredNorm();
                const GridIndex d = other - voxel;
                const int chess = std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
                if (chess < k) least = -1;  // it belongs to a nearer layer
                if (square >= least) return;
                least = square;
                nearest = &point;
              });
            }
            if (nearest != &source || least < 0) continue;
            if ((Centre(voxel) - source.place).dot(source.inward) >= 0) continue;  // inside
            ShellPoint point = source;
            point.voxel = voxel;
            point.place = Centre(voxel);
            layer[c].push_back(point);
          }
        }
      }
    }
    Order(layer[c]);
  });
  return layer;
}

using Gaps = decltype(Pointshell::gaps);

/// Returns Pointshell::gaps, in voxels, of points that have been shifted by `shift` voxels, at
/// steps of `step` voxels.
Gaps LargestGaps(const SurfaceVoxels& surface, const ChunkedPoints& points, double shift,
                 double step) {
  Gaps shifts;
  for (std::size_t k = 0; k < shifts.size(); ++k) {
    shifts[k] = shift + step * (static_cast<double>(k) - Pointshell::kGapSteps);
  }
  std::vector<Gaps> squares(points.size(), Gaps{});  // squares of the gaps
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t c) {
    // points of one voxel stand together
    const std::vector<ShellPoint>& own = points[c];
    std::array<std::uint16_t, kVoxelsPerChunk> first;  // per cell: 1 + the first of its points
    first.fill(0);
    for (std::size_t i = own.size(); i-- > 0;) {
      first[CellInBlock(own[i].voxel)] = static_cast<std::uint16_t>(i + 1);
    }
    for (const ShellPoint& point : own) {
      for (const GridIndex& side : {GridIndex{1, 0, 0}, GridIndex{0, 1, 0}, GridIndex{0, 0, 1}}) {
        Gaps nearest;
        nearest.fill(std::numeric_limits<double>::infinity());
        const auto measure = [&](const ShellPoint& other) {
          const Vec3 turn = other.inward - point.inward;
          const double along = 2 * Vec3(side.x, side.y, side.z).dot(turn);
          const double square = turn.squaredNorm();
          for (std::size_t k = 0; k < shifts.size(); ++k) {
            nearest[k] = std::min(nearest[k], 1 + shifts[k] * (along + shifts[k] * square));
          }
        };
        const GridIndex voxel = point.voxel + side;
        if ((voxel >> 3) == (point.voxel >> 3)) {
          const std::size_t at = first[CellInBlock(voxel)];
          for (std::size_t i = at - 1; at != 0 && i < own.size() && own[i].voxel == voxel; ++i) {
            measure(own[i]);
          }
        } else {
          ForEachPointAt(surface, points, voxel, measure);
        }
        if (nearest[0] == std::numeric_limits<double>::infinity()) continue;  // no point is there
        for (std::size_t k = 0; k < nearest.size(); ++k) {
          squares[c][k] = std::max(squares[c][k], nearest[k]);
        }
      }
    }
  });
  Gaps gaps{};
  for (const Gaps& of_chunk : squares) {
    for (std::size_t k = 0; k < gaps.size(); ++k) gaps[k] = std::max(gaps[k], of_chunk[k]);
  }
  for (double& gap : gaps) gap = std::sqrt(std::max(gap, 0.0));
  return gaps;
}

}  // namespace

double Pointshell::GapWhenDisplaced(double metres) const noexcept {
  const double at = metres / gap_step + static_cast<double>(kGapSteps);
  const double low = std::clamp(std::floor(at), 0.0, static_cast<double>(gaps.size() - 2));
  const auto k = static_cast<std::size_t>(low);
  return std::max(0.0, gaps[k] + (at - low) * (gaps[k + 1] - gaps[k]));
}

Result<Pointshell> MakePointshell(const TriangleMesh& mesh_W, const Pose& X_WB,
                                  const PointshellOptions& options) {
  const double s = options.spacing;
  if (std::optional<Error> fault =
          VoxelSizeFault(mesh_W, {.voxel_size = s, .max_memory_bytes = options.max_memory_bytes})) {
    return *fault;
  }
  return MakePointshell(mesh_W, FindFeatures(mesh_W, options.flatness_voxels * s), X_WB, options);
}

Result<Pointshell> MakePointshell(const TriangleMesh& mesh_W, const Features& features,
                                  const Pose& X_WB, const PointshellOptions& options) {
  const double s = options.spacing;
  if (std::optional<Error> fault =
          VoxelSizeFault(mesh_W, {.voxel_size = s, .max_memory_bytes = options.max_memory_bytes})) {
    return *fault;
  }
  const FeatureVoxels voxels = FindFeatureVoxels(mesh_W, features, s);
  ChunkedPoints made = SurfacePoints(voxels, mesh_W, features, options.place);

  Pointshell shell;
  shell.spacing = s;
  const double farthest = options.most_displacement > 0 ? options.most_displacement : s;
  shell.gap_step = farthest / Pointshell::kGapSteps;
  shell.gaps = LargestGaps(voxels.surface(), made, options.inward_shift / s, shell.gap_step / s);
  for (double& gap : shell.gaps) gap *= s;
  if (options.free_layer > 0) made = FreeLayerPoints(voxels.surface(), made, options.free_layer);

  const Pose X_BW = X_WB.Inverse();
  const Mat3 R_BW = X_BW.q.toRotationMatrix();
  for (const std::vector<ShellPoint>& points : made) {
    if (points.empty()) continue;
    Pointshell::Chunk group;
    group.first = static_cast<std::uint32_t>(shell.size());
    group.count = static_cast<std::uint32_t>(points.size());
    group.first_edge = static_cast<std::uint32_t>(shell.edges.size());
    Bounds box;
    for (const ShellPoint& point : points) {
      const Vec3 n_B = R_BW * point.inward;
      const Vec3 p_BP = R_BW * (s * point.place) + X_BW.p + options.inward_shift * n_B;
      shell.x.push_back(static_cast<float>(p_BP.x()));
      shell.y.push_back(static_cast<float>(p_BP.y()));
      shell.z.push_back(static_cast<float>(p_BP.z()));
      shell.nx.push_back(static_cast<float>(n_B.x()));
      shell.ny.push_back(static_cast<float>(n_B.y()));
      shell.nz.push_back(static_cast<float>(n_B.z()));
      shell.labels.push_back(point.label);
      ++group.labels[static_cast<std::size_t>(point.label)];
      if (options.place == PointPlace::kOnFeature && point.label == Label::kEdge) {
        shell.edges.push_back({(R_BW * point.tangent).cast<float>(),
                               static_cast<float>(s * point.half_length),
                               static_cast<float>(point.cosine), point.ends});
      }
      box.Add(shell.point(shell.size() - 1));
    }
    group.p_BC = box.centre();
    for (std::uint32_t i = group.first; i < group.first + group.count; ++i) {
      group.radius = std::max(group.radius, (shell.point(i) - group.p_BC).norm());
      shell.radius = std::max(shell.radius, shell.point(i).norm());
    }
    shell.chunks.push_back(group);
  }
  if (shell.size() == 0) return Error{"the mesh has no area"};
  return shell;
}

std::uint64_t Digest(const Pointshell& points) {
  Hash64 hash;
  for (const auto* values : {&points.x, &points.y, &points.z, &points.nx, &points.ny, &points.nz}) {
    hash.AddBytes(values->data(), values->size() * sizeof(float));
  }
  return hash.value();
}

}  // namespace tandem
