#include "engine/contact/features/crown_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>

#include "engine/voxel/map/voxel.h"

namespace tandem {

namespace {

/// The distance within which a place's neighbours tell whether it stands out from them, voxels.
constexpr double kNeighbours = 3;
/// The distance up to which a vertex's neighbours are searched for if none is within kNeighbours.
constexpr double kFarthestNeighbours = 24;
/// Sine of the turn at an edge from which on the surface bulges there; less is the rounding of a
/// plane.
constexpr double kBulges = 1e-4;
/// Sine of the turn at an edge from which on the edge is examined itself. Its ends do not suffice
/// for what lies across its middle.
constexpr double kTurns = 0.02;
/// Sine of the angle from the tangent plane up to which a point above it is beside the place. A
/// steeper point belongs to another part of the surface.
constexpr double kBeside = 0.5;

/// Keeps feature points by the cube of kNeighbours voxels that they lie in.
class PointCells {
 public:
  explicit PointCells(std::vector<FeaturePoint>& points) : points_(points) {
    for (std::uint32_t i = 0; i < points.size(); ++i) cells_[KeyOf(points[i].place_W)].push_back(i);
  }

  void Add(const Vec3& place, const Vec3& outward) {
    cells_[KeyOf(place)].push_back(static_cast<std::uint32_t>(points_.size()));
    points_.push_back({.place_W = place, .outward = outward});
  }

  /// Returns the voxels that a place stands out, along `outward`, from the plane on the highest
  /// point within `reach`; infinity if there is none.
  double StandsOut(const Vec3& place, const Vec3& outward, double reach) const {
    double least = std::numeric_limits<double>::infinity();
    const auto rings = static_cast<std::int32_t>(std::ceil(reach / kNeighbours));
    const GridIndex at = CellOf(place);
    for (std::int32_t z = -rings; z <= rings; ++z) {
      for (std::int32_t y = -rings; y <= rings; ++y) {
        for (std::int32_t x = -rings; x <= rings; ++x) {
          const auto found = cells_.find(MortonCode(at + GridIndex{x, y, z}));
          if (found == cells_.end()) continue;
          for (const std::uint32_t i : found->second) {
            const Vec3 from = place - points_[i].place_W;
            const double above = outward.dot(from);
            const double distance = from.norm();
            if (distance > reach || above < -kBeside * distance) continue;
            least = std::min(least, above);
          }
        }
      }
    }
    return least;
  }

 private:
  static GridIndex CellOf(const Vec3& place) {
    const auto along = [&](Eigen::Index axis) {
      return static_cast<std::int32_t>(std::floor(place[axis] / kNeighbours));
    };
    return {along(0), along(1), along(2)};
  }
  static std::uint64_t KeyOf(const Vec3& place) { return MortonCode(CellOf(place)); }

  std::vector<FeaturePoint>& points_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

/// A vertex as seen from the triangles round it.
struct Corner {
  Vec3 outward = Vec3::Zero();  // sum of the triangles' normals, weighted by their angles
  bool bulges = false;          // some edge at it bulges
  bool walled = false;          // some edge at it is not between two triangles
};

class Crowns {
 public:
  Crowns(const TriangleMesh& mesh_W, const MeshSides& sides, double voxel_size,
         std::vector<FeaturePoint>& points)
      : mesh_(mesh_W), sides_(sides), voxel_size_(voxel_size), cells_(points) {
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Vec3 across =
          (mesh_.corner(t, 1) - mesh_.corner(t, 0)).cross(mesh_.corner(t, 2) - mesh_.corner(t, 0));
      normals_.push_back(across.squaredNorm() > 0 ? Vec3(across.normalized()) : Vec3::Zero());
    }
  }

  void AddVertices() {
    const std::vector<Corner> corners = FindCorners();
    for (std::size_t v = 0; v < corners.size(); ++v) {
      const Corner& corner = corners[v];
      if (!corner.bulges || corner.walled || corner.outward.squaredNorm() == 0) continue;
      const Vec3 place = mesh_.vertices[v] / voxel_size_;
      const Vec3 outward = corner.outward.normalized();
      double above = std::numeric_limits<double>::infinity();
      for (double reach = kNeighbours; reach <= kFarthestNeighbours && !std::isfinite(above);
           reach *= 2) {
        above = cells_.StandsOut(place, outward, reach);
      }
      if (above > kMostStandingOut) cells_.Add(place, outward);
    }
  }

  void AddEdges() {
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t other = sides_.NeighborAcross(t, k);
        if (other == MeshSides::kNone || other < t || TurnAt(t, k, other) < kTurns) continue;
        const Vec3 outward = (normals_[t] + normals_[other]).normalized();
        const Vec3 from = mesh_.corner(t, k) / voxel_size_;
        const Vec3 way = mesh_.corner(t, (k + 1) % 3) / voxel_size_ - from;
        const int count = static_cast<int>(std::ceil(way.norm()));
        for (int i = 0; i < count; ++i) {
          const Vec3 place = from + (i + 0.5) / count * way;
          if (cells_.StandsOut(place, outward, kNeighbours) > kMostStandingOut) {
            cells_.Add(place, outward);
          }
        }
      }
    }
  }

 private:
  /// Returns the sine of the angle by which the surface turns at a side of a triangle, above 0
  /// where it bulges.
  double TurnAt(std::uint32_t t, std::uint32_t k, std::uint32_t other) const {
    const Vec3 along = mesh_.corner(t, (k + 1) % 3) - mesh_.corner(t, k);
    return normals_[t].cross(normals_[other]).dot(along.normalized());
  }

  std::vector<Corner> FindCorners() const {
    std::vector<Corner> corners(mesh_.vertices.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      for (std::uint32_t k = 0; k < 3; ++k) {
        const auto vertex_at = [&](std::uint32_t c) -> Corner& {
          return corners[mesh_.triangles[t][c]];
        };
        Corner& corner = vertex_at(k);
        const std::uint32_t next = (k + 1) % 3;
        const Vec3 along = mesh_.corner(t, next) - mesh_.corner(t, k);
        const Vec3 back = mesh_.corner(t, (k + 2) % 3) - mesh_.corner(t, k);
        corner.outward += std::atan2(along.cross(back).norm(), along.dot(back)) * normals_[t];
        const std::uint32_t other = sides_.NeighborAcross(t, k);
        const bool walled = other == MeshSides::kNone;
        const bool bulges = !walled && TurnAt(t, k, other) > kBulges;
        for (Corner* end : {&corner, &vertex_at(next)}) {
          end->walled = end->walled || walled;
          end->bulges = end->bulges || bulges;
        }
      }
    }
    return corners;
  }

  const TriangleMesh& mesh_;
  const MeshSides& sides_;
  double voxel_size_;
  PointCells cells_;
  std::vector<Vec3> normals_;  // unit, by triangle; zero for one without area
};

}  // namespace

void AddCrownPoints(const TriangleMesh& mesh_W, const MeshSides& sides, double voxel_size,
                    std::vector<FeaturePoint>& points) {
  Crowns crowns(mesh_W, sides, voxel_size, points);
  crowns.AddVertices();
  crowns.AddEdges();
}

}  // namespace tandem
