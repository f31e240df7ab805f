#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/geometry/triangle_mesh.h"

namespace tandem {

/// What is wrong with a mesh, if anything, and which triangles hang together.
struct MeshDiagnosis {
  std::size_t bodies = 0;              // connected components over shared vertices
  std::size_t open_edges = 0;          // used by one triangle
  std::size_t non_manifold_edges = 0;  // used by more than two
  std::size_t flipped_edges = 0;       // used by two that run the same way
  std::size_t flat_triangles = 0;      // of no area
  std::vector<std::uint32_t> body_of_triangle;

  /// Every edge is used exactly twice, in opposite directions.
  bool closed() const { return open_edges + non_manifold_edges + flipped_edges == 0; }
};

MeshDiagnosis Diagnose(const TriangleMesh& mesh);

/// One line for a person: "closed, 1 body" or "108 open edges, 32 flat triangles; 1 body".
std::string Describe(const MeshDiagnosis& diagnosis);

}  // namespace tandem
