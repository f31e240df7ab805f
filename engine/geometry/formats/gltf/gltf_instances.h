#pragma once

#include <vector>

#include "engine/base/result.h"
#include "engine/base/text/json_reader.h"
#include "engine/geometry/formats/affine34.h"
#include "engine/geometry/formats/gltf/gltf_numbers.h"

namespace tandem {

/// Tells whether a node's mesh stands in several places (EXT_mesh_gpu_instancing).
bool HasGltfInstances(const JsonNode& node);

/// Returns where the copies of a node's mesh stand; `X_MN`: placing of the node. The error is that
/// of its numbers.
Result<std::vector<Affine34>> GltfInstancesOf(const JsonNode& node, const Affine34& X_MN,
                                              GltfNumbers& numbers);

}  // namespace tandem
