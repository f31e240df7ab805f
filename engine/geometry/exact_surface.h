#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "engine/geometry/box_tree.h"
#include "engine/geometry/triangle_mesh.h"
#include "engine/geometry/union_boundary.h"
#include "engine/geometry/winding_number.h"

namespace tandem {

/// The union of a mesh's bodies as exact geometry in double precision, with no voxels in it: the
/// judge of what the voxmap did.
///
/// Inside is where the generalized winding number is at least one half (see WindingNumber for why).
/// Overlapping bodies are one solid, cavities are outside, T-junction cracks do not matter, and a
/// closed body turned inside out is turned right. A flat sheet encloses nothing, so nothing can lie
/// in it; an open bowl encloses its hollow.
///
/// Depth is the distance to the surface of the *union*, to the last bit the closest point of the
/// triangles that bound it: a face of one body inside another does not count (UnionBoundary), so
/// two bolts through a plate do not make its middle look shallow. In a body with a real hole the
/// opening counts as no surface, which can only make the depth larger.
///
/// Any number of threads may ask at once.
class ExactSurface {
 public:
  enum class Side { kUnknown, kInside, kOutside };

  /// What the caller knows of a depth already; saves time, and must be true.
  struct Hint {
    double at_most = std::numeric_limits<double>::infinity();  // |depth|, m
    Side side = Side::kUnknown;
  };

  explicit ExactSurface(const TriangleMesh& mesh);

  /// Whether the mesh encloses anything at all.
  bool empty() const { return facets_.empty(); }
  std::size_t facet_count() const { return facets_.size(); }

  /// By the winding number alone.
  bool Contains(const Vec3& p) const { return winding_.At(p) >= 0.5; }

  /// From p to the surface (m), or `cut_off` if that is nearer.
  double Distance(const Vec3& p, double cut_off = std::numeric_limits<double>::infinity()) const;

  /// How deep p lies in the union (m): distance to its surface inside, minus that outside, minus
  /// infinity if the mesh encloses nothing. Changes by no more than p moves, but through a real
  /// hole.
  double Depth(const Vec3& p) const { return Depth(p, Hint{}); }
  double Depth(const Vec3& p, const Hint& hint) const;

  /// The point of the union's surface closest to p. The mesh must enclose something.
  Vec3 ClosestPoint(const Vec3& p) const;

 private:
  struct Closest {
    double squared_distance;
    Vec3 point = Vec3::Zero();
    std::uint32_t facet = 0;
    bool on_face = false;  // not on an edge or a corner
  };
  Closest Search(const Vec3& p, double cut_off) const;
  bool SolidAt(const Vec3& p) const;

  struct TurnedOut {
    TriangleMesh mesh;
  };
  explicit ExactSurface(const TurnedOut& turned_out);

  double tolerance_;
  WindingNumber winding_;
  BoxTree tree_;
  std::vector<Facet> facets_;  // in the tree's order
};

}  // namespace tandem
