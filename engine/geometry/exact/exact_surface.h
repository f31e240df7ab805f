#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "engine/geometry/exact/box_tree.h"
#include "engine/geometry/exact/union_boundary.h"
#include "engine/geometry/exact/winding_number.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// The union of a mesh's bodies as exact geometry in double precision, without voxels. It is the
/// reference by which the voxmap is judged.
///
/// A place is inside where the generalized winding number is at least one half (see WindingNumber
/// for why). Overlapping bodies are one solid, cavities are outside, T-junction cracks do not
/// matter, and a closed body turned inside out is turned right. A flat sheet encloses nothing, so
/// no place is inside it; an open bowl encloses its hollow.
///
/// Depth is the distance to the surface of the *union*, to the last bit that of the closest point
/// of the triangles that bound it. A face of one body inside another does not count
/// (UnionBoundary), so two bolts through a plate do not make its middle look shallow. In a body
/// with a real hole the opening is not part of the surface, which can only make the depth larger.
///
/// Any number of threads may use it at once.
class ExactSurface {
 public:
  enum class Side { kUnknown, kInside, kOutside };

  /// Facts that the caller knows of a depth already. They save time, and must be true.
  struct Hint {
    double at_most = std::numeric_limits<double>::infinity();  // |depth|, m
    Side side = Side::kUnknown;
  };

  explicit ExactSurface(const TriangleMesh& mesh);

  /// Tells whether the mesh encloses nothing.
  bool empty() const { return facets_.empty(); }
  std::size_t facet_count() const { return facets_.size(); }

  /// Tells whether p is inside, by the winding number alone.
  bool Contains(const Vec3& p) const { return winding_.At(p) >= 0.5; }

  /// Returns the distance from p to the surface (m), or `cut_off` if that is nearer.
  double Distance(const Vec3& p, double cut_off = std::numeric_limits<double>::infinity()) const;

  /// Returns the depth of p in the union (m): distance to its surface inside, minus that outside,
  /// minus infinity if the mesh encloses nothing. It changes by at most the distance that p moves,
  /// except through a real hole.
  double Depth(const Vec3& p) const { return Depth(p, Hint{}); }
  double Depth(const Vec3& p, const Hint& hint) const;

  /// Returns the point of the union's surface closest to p. The mesh must enclose something.
  Vec3 ClosestPoint(const Vec3& p) const;
  /// Returns the facet of the union's surface closest to p. No place is deeper than it is far from
  /// any facet. The mesh must enclose something.
  const Facet& ClosestFacet(const Vec3& p) const;

  /// Tells whether a triangle may meet the union's surface. Where it does, the answer is yes; the
  /// answer may be yes for a triangle in the plane of a facet beside it.
  bool MayMeet(const std::array<Vec3, 3>& corners) const;

 private:
  struct Closest {
    double squared_distance;
    Vec3 point = Vec3::Zero();
    std::uint32_t facet = 0;
    bool on_face = false;  // not on an edge or a corner
  };
  Closest Search(const Vec3& p, double cut_off) const;
  bool SolidAt(const Vec3& p) const;

  struct OutwardOriented {
    TriangleMesh mesh;
  };
  explicit ExactSurface(const OutwardOriented& turned_out);

  double tolerance_;
  WindingNumber winding_;
  BoxTree tree_;
  std::vector<Facet> facets_;  // in the tree's order
};

}  // namespace tandem
