#pragma once

#include <cstdint>
#include <span>

#include "engine/base/files/block_file.h"
#include "engine/base/hash.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Returns a hash of a mesh: its vertices and triangles, in their order.
inline std::uint64_t HashOf(const TriangleMesh& mesh) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  Hash64 hash;
  hash.Add(std::uint64_t{mesh.vertices.size()});
  hash.Add(HashOfMany(std::as_bytes(std::span(mesh.vertices))));
  hash.Add(HashOfMany(std::as_bytes(std::span(mesh.triangles))));
  return hash.value();
}

}  // namespace tandem
