#pragma once

#include <cstdint>
#include <span>

#include "engine/base/files/sha256.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Returns the digest of a mesh: its vertices and triangles, in their order.
inline Sha256 DigestOf(const TriangleMesh& mesh) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  RunningSha256 digest;
  digest.Add(Sha256OfMany(std::as_bytes(std::span(mesh.vertices))));
  digest.Add(Sha256OfMany(std::as_bytes(std::span(mesh.triangles))));
  return digest.Value();
}

}  // namespace tandem
