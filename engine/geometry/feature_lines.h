#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/base/huge_vector.h"
#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// The lines that feature edges make, and where vertices stand on them: where lines meet otherwise
/// than two pieces of one, and where one leaves its chord (FindFeatures(), paper §4.1).
class FeatureLines {
 public:
  struct Edge {
    std::array<std::uint32_t, 2> ends;
    std::array<std::uint32_t, 2> polygons;  // on its two sides; equal for a wall within nothing
  };

  FeatureLines(const TriangleMesh& mesh, HugeVector<Edge> edges);

  /// In rising order; `tolerance` (m) from a chord.
  std::vector<std::uint32_t> FindVertices(double tolerance);

 private:
  /// Follows a line from a vertex by an edge to its end, and marks where it leaves its chord.
  void Walk(std::uint32_t start, std::uint32_t edge, const std::vector<std::uint8_t>& ends,
            double tolerance);
  bool LeavesChord(std::size_t from, std::size_t to, double tolerance) const;

  const TriangleMesh& mesh_;
  HugeVector<Edge> edges_;
  HugeVector<std::uint32_t> first_;  // per vertex: into at_
  HugeVector<std::uint32_t> at_;     // edges
  std::vector<std::uint8_t> corner_;
  std::vector<std::uint8_t> walked_;
  std::vector<std::uint32_t> run_;
};

}  // namespace tandem
