#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/files/sha256.h"
#include "engine/base/result.h"
#include "engine/scene/scene.h"

namespace tandem {

/// The hashes that peers compare before they touch one another. They do not depend on names,
/// colours, hands or the places of files.
///
/// The 64-bit hashes name scenes and bodies briefly, in older recordings and in messages for
/// people. Two contents with one such hash are made in a second, so nothing is trusted for its
/// hash: what decides is the digest (docs/decisions/0063-digests.md).
struct SceneHash {
  struct Body {
    std::uint64_t values = 0;  // scale, placement, mass, sharing, constraint, …
    std::uint64_t mesh = 0;    // bytes of its mesh file, and of a glTF file's buffers
    Sha256 mesh_digest{};      // SHA-256 of the file; of several files, of their digests

    friend bool operator==(const Body&, const Body&) = default;
  };

  std::uint64_t content = 0;  // hash of all bodies, of pairs and gravity; not of force parameters
  Sha256 digest{};            // SHA-256 of the same: it alone tells that two scenes are one
  std::uint64_t parameters = 0;  // hash of voxel size and force parameters
  std::vector<Body> bodies;      // in the scene's order
};

/// Hashes a scene. Reads the bytes of regular files, up to 4 GB for a mesh. The error names the
/// file.
Result<SceneHash> HashScene(const Scene& scene);

}  // namespace tandem
