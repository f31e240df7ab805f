#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/peak_memory.h"
#include "engine/base/result.h"
#include "engine/geometry/mesh/facets.h"
#include "engine/geometry/mesh/triangle_mesh.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

/// A body's surface as points that are tested against other bodies' voxmaps (paper §2.1, §3.2, §4).
/// There is one point for every surface voxel of its own voxelization. It has the voxel's label and
/// a unit normal that points into the body. Where both sides of a thin sheet lie in one voxel, each
/// side has a point. On features each edge beside a vertex or a longer edge has one more. Points
/// are grouped by chunk, within a chunk by label, the vertices first, and then by neighbourhood.
/// Coordinates are in the body's frame B. Read-only once built.
struct Pointshell {
  /// Points [first, first + count), from one chunk.
  struct Chunk {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    std::uint32_t first_edge = 0;                 // index into `edges`, of its edge points in order
    std::array<std::uint32_t, kFields> labels{};  // number of points of each Label
    Vec3 p_BC = Vec3::Zero();                     // centre of the points' box, m
    double radius = 0;  // radius of the ball round it that holds them all, m
  };
  /// The part of a feature edge that lies in an edge point's voxel.
  struct Edge {
    Vec3f tangent = Vec3f::Zero();  // unit, in B
    float half_length = 0;          // m; the point is its middle
    float cosine = 0;               // as FeatureNormals::edge_cosines
    /// The part ends at a vertex in its voxel, which the tangent points away from.
    bool ends = false;
  };

  double spacing = 0;             // voxel size of its voxelization, m
  std::vector<float> x, y, z;     // p_BP, m
  std::vector<float> nx, ny, nz;  // inward unit normals
  std::vector<Label> labels;      // labels of their voxels
  std::vector<Edge> edges;        // edges of the edge points, in order; empty unless on features
  std::vector<Chunk> chunks;
  double radius = 0;  // largest distance of a point from Bo, m
  /// Returns the greatest distance between points of voxels that share a face, m, when all points
  /// are displaced by `metres` more along their inward normals. Above the voxel size of a map,
  /// something may slip through between them. It counts from voxel to voxel and ignores the places
  /// of points in their voxels. Between whole steps and beyond the last it interpolates linearly.
  double GapWhenDisplaced(double metres) const noexcept;
  static constexpr std::size_t kGapSteps = 4;    // in either direction
  double gap_step = 0;                           // m
  std::array<double, 2 * kGapSteps + 1> gaps{};  // gaps by displacement, outwards first, m

  std::size_t size() const noexcept { return x.size(); }
  Vec3 point(std::size_t i) const { return Vec3(x[i], y[i], z[i]); }
  Vec3 normal(std::size_t i) const { return Vec3(nx[i], ny[i], nz[i]); }
  Label label(std::size_t i) const { return labels[i]; }
};

/// The place of a point in its voxel.
enum class PointPlace : std::uint8_t {
  kVoxelCentre,  // as in the paper
  kOnFeature     // on the exact vertex, edge or surface
};

struct PointshellOptions {
  double spacing = 0.001;   // m
  double inward_shift = 0;  // shift along the normals, m; negative shifts outward
  PointPlace place = PointPlace::kVoxelCentre;
  /// Flatness of quasi-planar polygons, voxels either side (paper §4.1).
  double flatness_voxels = 0.5;
  /// The farthest that points will be displaced later, in either direction, m; 0: by their spacing.
  double most_displacement = 0;
  /// 0: the surface voxels themselves. k: the k-th free-space layer of the body, for a clearance
  /// that the force layer cannot give (paper §3.2); labels and normals are those of the nearest
  /// surface voxel.
  int free_layer = 0;
  std::size_t max_memory_bytes = PeakMemory();
};

/// Makes the points of a mesh that stands in W, in the frame B that stands at X_WB at that time.
Result<Pointshell> MakePointshell(const TriangleMesh& mesh_W, const Pose& X_WB,
                                  const PointshellOptions& options);
/// Does the same with features found before, with the same flatness.
Result<Pointshell> MakePointshell(const TriangleMesh& mesh_W, const Features& features,
                                  const Pose& X_WB, const PointshellOptions& options);

/// Returns a hash of the points and normals, in their (Morton) order.
std::uint64_t Digest(const Pointshell& points);

}  // namespace tandem
