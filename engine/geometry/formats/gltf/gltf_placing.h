#pragma once

#include "engine/base/result.h"
#include "engine/base/spatial.h"
#include "engine/base/text/json_reader.h"
#include "engine/geometry/formats/affine34.h"

namespace tandem {

/// Returns the linear part of a turn by a quaternion, which may have any length but 0.
Mat3 TurnBy(double x, double y, double z, double w);

/// Returns where a node stands in its parent. The error continues "glTF: ".
Result<Affine34> LocalPlacing(const JsonNode& node);

}  // namespace tandem
