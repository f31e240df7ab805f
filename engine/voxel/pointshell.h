#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/most_memory.h"
#include "engine/base/result.h"
#include "engine/geometry/facets.h"
#include "engine/geometry/triangle_mesh.h"
#include "engine/voxel/voxel.h"

namespace tandem {

/// A body's surface as points that are tested against other bodies' voxmaps (paper §2.1, §3.2, §4):
/// one for every surface voxel of its own voxelization, with its voxel's label and a unit normal
/// that points into the body. Where both sides of a thin sheet lie in one voxel there is a point
/// for each; on features, one more for each edge beside a vertex or a longer edge. Grouped by
/// chunk, in a chunk by label, the vertices first, and then so that neighbours stand together.
/// Coordinates in the body's frame B; read-only once built.
struct Pointshell {
  /// Points [first, first + count), from one chunk.
  struct Chunk {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    std::uint32_t first_edge = 0;                 // into `edges`, of its edge points in order
    std::array<std::uint32_t, kFields> labels{};  // how many of each Label
    Vec3 p_BC = Vec3::Zero();                     // centre of the points' box, m
    double radius = 0;                            // of the ball round it that holds them all, m
  };
  /// The part of a feature edge that lies in an edge point's voxel.
  struct Edge {
    Vec3f tangent = Vec3f::Zero();  // unit, in B
    float half_length = 0;          // m; the point is its middle
    float cosine = 0;               // as FeatureNormals::edge_cosines
    bool ends = false;              // at a vertex in its voxel, which the tangent points away from
  };

  double spacing = 0;             // voxel size of its voxelization, m
  std::vector<float> x, y, z;     // p_BP, m
  std::vector<float> nx, ny, nz;  // inward unit normals
  std::vector<Label> labels;      // of their voxels
  std::vector<Edge> edges;        // of the edge points, in order; empty unless on features
  std::vector<Chunk> chunks;
  double radius = 0;  // largest distance of a point from Bo, m
  /// How far points of voxels that share a face stand apart at the most, m, when all are displaced
  /// by `metres` more along their inward normals. Above the voxel size of a map, something may slip
  /// through between them. Counted from voxel to voxel: where in its voxel a point stands is not in
  /// it. Between whole steps and beyond the last it is as of straight lines.
  double GapWhenDisplaced(double metres) const noexcept;
  static constexpr std::size_t kGapSteps = 4;    // either way
  double gap_step = 0;                           // m
  std::array<double, 2 * kGapSteps + 1> gaps{};  // m, by displacement, outwards first

  std::size_t size() const noexcept { return x.size(); }
  Vec3 point(std::size_t i) const { return Vec3(x[i], y[i], z[i]); }
  Vec3 normal(std::size_t i) const { return Vec3(nx[i], ny[i], nz[i]); }
  Label label(std::size_t i) const { return labels[i]; }
};

/// Where in its voxel a point stands.
enum class PointPlace : std::uint8_t {
  kVoxelCentre,  // the paper's
  kOnFeature     // on the exact vertex, edge or surface
};

struct PointshellOptions {
  double spacing = 0.001;   // m
  double inward_shift = 0;  // along the normals, m; negative shifts outward
  PointPlace place = PointPlace::kVoxelCentre;
  double flatness_voxels = 0.5;  // of quasi-planar polygons, either side (paper §4.1)
  /// The farthest that points will be displaced later, either way, m; 0: by their spacing.
  double most_displacement = 0;
  /// 0: the surface voxels themselves. k: the k-th free-space layer of the body, for a clearance
  /// that the force layer cannot give (paper §3.2); labels and normals are the nearest surface
  /// voxel's.
  int free_layer = 0;
  std::size_t max_memory_bytes = MostMemory();
};

/// Makes the points of a mesh that stands in W, in the frame B that stands at X_WB then.
Result<Pointshell> MakePointshell(const TriangleMesh& mesh_W, const Pose& X_WB,
                                  const PointshellOptions& options);
/// With the features found already, with the same flatness.
Result<Pointshell> MakePointshell(const TriangleMesh& mesh_W, const Features& features,
                                  const Pose& X_WB, const PointshellOptions& options);

/// A hash of the points and normals, in their (Morton) order.
std::uint64_t Digest(const Pointshell& points);

}  // namespace tandem
