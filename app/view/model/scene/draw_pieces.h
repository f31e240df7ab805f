#pragma once

#include <cstdint>
#include <vector>

#include "app/view/model/scene/drawn_scene.h"

namespace tandem {

/// A range of a body's triangles or edges, drawn in one call.
struct DrawPiece {
  std::size_t body = 0;
  bool edges = false;
  std::size_t first = 0;  // vertex index in the body's list
  std::size_t count = 0;  // vertex indices
};

inline constexpr std::size_t kPieceTriangles = 16'384;

/// Returns the vertex indices of a mesh's triangles in the order in which they are drawn. A mesh of
/// one piece keeps its order. In a greater mesh, runs of neighbouring triangles are sorted by their
/// area, largest first, so that the first pieces cover most of the body.
std::vector<std::uint32_t> TrianglesInDrawingOrder(const ShadedMesh& mesh);

/// Cuts the fixed bodies into pieces. The triangles come before all edges. The first piece of each
/// body comes first, then the second piece of each, so that every body is soon seen.
std::vector<DrawPiece> PiecesOfFixedBodies(const std::vector<DrawnBody>& bodies);

}  // namespace tandem
