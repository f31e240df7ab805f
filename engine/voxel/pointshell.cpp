#include "engine/voxel/pointshell.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include <tbb/parallel_for.h>

#include "engine/base/hash.h"
#include "engine/voxel/surface_voxels.h"
#include "engine/voxel/voxelize.h"

namespace tandem {

namespace {

/// Of the summed areas: when the mean normal is shorter, the facets face several ways (VPS.md
/// §3.2).
constexpr double kThinSheet = 0.3;

/// A triangle cut to a box has at most nine corners.
struct Polygon {
  std::array<Vec3, 10> corners;
  std::size_t count = 0;
};

/// Cuts away what lies beyond `limit` along an axis; `side` +1 keeps the lower part, -1 the upper.
void Clip(Polygon& polygon, int axis, double limit, double side) {
  Polygon kept;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const Vec3& a = polygon.corners[i];
    const Vec3& b = polygon.corners[(i + 1) % polygon.count];
    const double da = side * (limit - a[axis]);
    const double db = side * (limit - b[axis]);
    if (da >= 0) kept.corners[kept.count++] = a;
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      kept.corners[kept.count++] = a + da / (da - db) * (b - a);
    }
  }
  polygon = kept;
}

/// Twice the area vector of a triangle's part within the unit cell at `cell`, in voxel units.
Vec3 ClippedArea(const std::array<Vec3, 3>& triangle, const Vec3& cell) {
  Polygon polygon;
  polygon.count = 3;
  std::copy(triangle.begin(), triangle.end(), polygon.corners.begin());
  for (int axis = 0; axis < 3; ++axis) {
    Clip(polygon, axis, cell[axis], -1.0);
    Clip(polygon, axis, cell[axis] + 1.0, 1.0);
  }
  Vec3 area = Vec3::Zero();
  for (std::size_t i = 2; i < polygon.count; ++i) {
    area += (polygon.corners[i - 1] - polygon.corners[0])
                .cross(polygon.corners[i] - polygon.corners[0]);
  }
  return area;
}

/// The inward normals of a voxel's points: one, or one a side where its facets face apart.
std::vector<Vec3> InwardNormals(const std::vector<Vec3>& outward_areas) {
  Vec3 sum = Vec3::Zero();
  double total = 0;
  for (const Vec3& area : outward_areas) {
    sum += area;
    total += area.norm();
  }
  if (total <= 0) return {};
  if (sum.norm() >= kThinSheet * total) return {-sum.normalized()};
  // largest first, each to the first cluster within 90 degrees
  std::vector<Vec3> ordered = outward_areas;
  std::stable_sort(ordered.begin(), ordered.end(), [](const Vec3& a, const Vec3& b) {
    return a.squaredNorm() > b.squaredNorm();
  });
  std::vector<Vec3> clusters;
  for (const Vec3& area : ordered) {
    const auto same = std::find_if(clusters.begin(), clusters.end(), [&](const Vec3& cluster) {
      return cluster.dot(area) > 0;
    });
    if (same == clusters.end()) {
      clusters.push_back(area);
    } else {
      *same += area;
    }
  }
  std::vector<Vec3> normals;
  for (const Vec3& cluster : clusters) {
    if (cluster.norm() > 0) normals.push_back(-cluster.normalized());
  }
  return normals;
}

struct ChunkPoints {
  std::vector<Vec3> points_W;
  std::vector<Vec3> normals_W;
};

ChunkPoints PointsOfChunk(const SurfaceVoxels& surface, const SurfaceVoxels::Chunk& chunk,
                          const TriangleMesh& mesh_W, const std::vector<SnappedTriangle>& snapped) {
  const double s = surface.voxel_size;
  const GridIndex first = chunk.place * kChunkSide;
  std::array<std::vector<Vec3>, kVoxelsPerChunk> areas;
  for (const std::uint32_t t : surface.TrianglesOf(chunk)) {
    SurfaceVoxels::Bits met{};
    TriangleOverlap(snapped[t]).MarkBlock(chunk.place, kSnapBits, met);
    const Vec3 origin(first.x, first.y, first.z);
    const std::array<Vec3, 3> triangle{mesh_W.corner(t, 0) / s - origin,
                                       mesh_W.corner(t, 1) / s - origin,
                                       mesh_W.corner(t, 2) / s - origin};
    const Vec3 whole = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    if (whole.norm() <= 0) continue;
    for (std::size_t word = 0; word < 8; ++word) {
      for (std::uint64_t rest = met[word]; rest != 0; rest &= rest - 1) {
        const std::size_t cell = 64 * word + static_cast<std::size_t>(std::countr_zero(rest));
        const GridIndex c = BlockCell(cell);
        // a triangle that only touches the cell still says which way the surface faces
        const Vec3 area = ClippedArea(triangle, Vec3(c.x, c.y, c.z));
        areas[cell].push_back(area + 1e-9 * whole.normalized());
      }
    }
  }
  ChunkPoints out;
  for (std::size_t cell = 0; cell < kVoxelsPerChunk; ++cell) {
    if (areas[cell].empty()) continue;
    const GridIndex i = first + BlockCell(cell);
    const Vec3 centre = s * (Vec3(i.x, i.y, i.z) + Vec3::Constant(0.5));
    for (const Vec3& normal : InwardNormals(areas[cell])) {
      out.points_W.push_back(centre);
      out.normals_W.push_back(normal);
    }
  }
  return out;
}

}  // namespace

Result<Pointshell> MakePointshell(const TriangleMesh& mesh_W, const Pose& X_WB,
                                  const PointshellOptions& options) {
  if (std::optional<Error> fault =
          VoxelSizeFault(mesh_W, options.spacing, options.max_memory_bytes)) {
    return *fault;
  }
  const std::vector<SnappedTriangle> snapped = SnapTriangles(mesh_W, options.spacing);
  const SurfaceVoxels surface = FindSurfaceVoxels(snapped, options.spacing);
  std::vector<ChunkPoints> made(surface.chunks.size());
  tbb::parallel_for(std::size_t{0}, made.size(), [&](std::size_t c) {
    made[c] = PointsOfChunk(surface, surface.chunks[c], mesh_W, snapped);
  });

  Pointshell shell;
  shell.spacing = options.spacing;
  const Pose X_BW = X_WB.Inverse();
  for (const ChunkPoints& chunk : made) {
    Pointshell::Chunk group;
    group.first = static_cast<std::uint32_t>(shell.size());
    group.count = static_cast<std::uint32_t>(chunk.points_W.size());
    if (group.count == 0) continue;
    Bounds box;
    for (std::size_t i = 0; i < chunk.points_W.size(); ++i) {
      const Vec3 n_B = X_BW.q * chunk.normals_W[i];
      const Vec3 p_BP = X_BW * chunk.points_W[i] + options.inward_shift * n_B;
      shell.x.push_back(static_cast<float>(p_BP.x()));
      shell.y.push_back(static_cast<float>(p_BP.y()));
      shell.z.push_back(static_cast<float>(p_BP.z()));
      shell.nx.push_back(static_cast<float>(n_B.x()));
      shell.ny.push_back(static_cast<float>(n_B.y()));
      shell.nz.push_back(static_cast<float>(n_B.z()));
      shell.labels.push_back(Label::kVertex);
      box.Add(shell.point(group.first + i));
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
