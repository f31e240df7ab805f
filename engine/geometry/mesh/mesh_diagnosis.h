#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// The faults of a mesh, and its connected triangles.
struct MeshDiagnosis {
  std::size_t bodies = 0;              // connected components over shared vertices
  std::size_t open_edges = 0;          // edges of one triangle
  std::size_t non_manifold_edges = 0;  // edges of more than two triangles
  std::size_t flipped_edges = 0;       // edges of two triangles that run the same way
  std::size_t flat_triangles = 0;      // triangles without area
  std::vector<std::uint32_t> body_of_triangle;

  /// Tells whether every edge is used exactly twice, in opposite directions.
  bool closed() const { return open_edges + non_manifold_edges + flipped_edges == 0; }
};

MeshDiagnosis Diagnose(const TriangleMesh& mesh);

/// Returns one line for a person: "closed, 1 body" or "108 open edges, 32 flat triangles; 1 body".
std::string Describe(const MeshDiagnosis& diagnosis);

}  // namespace tandem
