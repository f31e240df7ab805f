#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/huge_vector.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// The connections of a mesh's triangles along their sides. Side k of triangle t, number 3 t + k,
/// runs from its corner k to the next.
class MeshSides {
 public:
  static constexpr std::uint32_t kNone = ~0U;

  /// An edge that is open, non-manifold or wound inconsistently. Any other edge belongs to two
  /// triangles that run it in opposite directions.
  struct Wall {
    std::array<std::uint32_t, 2> ends;  // vertices, the lesser first
    std::uint32_t first = 0;            // first of its sides, as an index into wall_sides()
    std::uint32_t count = 0;
  };

  explicit MeshSides(const TriangleMesh& mesh);

  std::size_t triangles() const noexcept { return across_.size() / 3; }
  /// Returns the triangle across side k of a triangle; kNone at a wall.
  std::uint32_t NeighborAcross(std::uint32_t triangle, std::uint32_t k) const noexcept {
    return across_[3 * triangle + k];
  }
  /// Returns the walls in rising order of their ends.
  const std::vector<Wall>& walls() const noexcept { return walls_; }
  const std::vector<std::uint32_t>& wall_sides() const noexcept { return wall_sides_; }
  /// Returns the number of bodies: triangles connected over shared vertices, in the order of their
  /// first triangles.
  std::size_t bodies() const noexcept { return bodies_; }
  std::uint32_t BodyOf(std::size_t triangle) const noexcept { return body_of_[triangle]; }

 private:
  void FindSides(const TriangleMesh& mesh);
  void FindBodies(const TriangleMesh& mesh);

  HugeVector<std::uint32_t> across_;
  std::vector<Wall> walls_;
  std::vector<std::uint32_t> wall_sides_;
  HugeVector<std::uint32_t> body_of_;
  std::size_t bodies_ = 0;
};

}  // namespace tandem
