#pragma once

#include <optional>

#include "engine/field/query/distance_field.h"

namespace tandem {

/// The thickness of walls below which a point that has come through is pushed back, voxels.
inline constexpr double kThickest = 1.9;

/// Returns the share of a push on the middle of a sharp edge's part that counts. It is nothing
/// where the other body's edge, which turns by 20 degrees or more, is nearest: crossing edges push
/// as lines (CollideEdges()). It is nothing where the surface comes nearer along the part: then
/// another part, or the edge's end, touches. It is 1 a quarter of a voxel deep, where edges may
/// have passed one another.
double ShareOnEdge(const FieldPush& push, const Vec3& tangent) noexcept;
/// Returns the thickness of the solid behind the place on its surface that pushes a point, voxels;
/// nothing from kThickest on.
std::optional<double> Thickness(const DistanceField& field, const Vec3& point_V,
                                const FieldPush& push) noexcept;
/// Turns the push on a point that has come through a wall back to the side that it came from.
FieldPush Reversed(FieldPush push, double thickness) noexcept;

}  // namespace tandem
