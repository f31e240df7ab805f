#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/huge_vector.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// The lines of feature edges. Finds the vertices on them: where lines meet, except two pieces of
/// one line, and where a line leaves its chord (FindFeatures(), paper §4.1).
class FeatureLines {
 public:
  struct Edge {
    std::array<std::uint32_t, 2> ends;
    /// Polygons on its two sides, the lesser first; MeshSides::kNone for both of a wall.
    std::array<std::uint32_t, 2> polygons;
  };

  FeatureLines(const TriangleMesh& mesh, HugeVector<Edge> edges);

  /// Returns the vertices in rising order; `tolerance` (m) from a chord.
  std::vector<std::uint32_t> FindVertices(double tolerance);

 private:
  /// Follows a line from a vertex by an edge to its end, and marks where it leaves its chord.
  void Walk(std::uint32_t start, std::uint32_t edge, const std::vector<std::uint8_t>& ends,
            double tolerance);
  bool LeavesChord(std::size_t from, std::size_t to, double tolerance) const;

  const TriangleMesh& mesh_;
  HugeVector<Edge> edges_;
  HugeVector<std::uint32_t> first_;  // per vertex: index into at_
  HugeVector<std::uint32_t> at_;     // edges
  std::vector<std::uint8_t> corner_;
  std::vector<std::uint8_t> walked_;
  std::vector<std::uint32_t> run_;
};

}  // namespace tandem
