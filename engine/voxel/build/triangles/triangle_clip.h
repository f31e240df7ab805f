#pragma once

#include <array>

#include "engine/base/spatial.h"

namespace tandem {

/// A triangle's part within a cell: twice its area vector, and its centre times the norm of that.
struct TrianglePart {
  Vec3 area = Vec3::Zero();
  Vec3 moment = Vec3::Zero();
};

/// Returns the part of a triangle in the unit cell whose lowest corner is `cell`.
TrianglePart PartInCell(const std::array<Vec3, 3>& triangle, const Vec3& cell);

}  // namespace tandem
