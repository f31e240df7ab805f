#include "engine/contact/field/push_rules.h"

#include <cmath>

#include "engine/contact/field/fading.h"

namespace tandem {

double ShareOnEdge(const FieldPush& push, const Vec3& tangent) noexcept {
  const double on_face =
      Fading(push.facing, 0.985, 0.940) * Fading(std::abs(push.away_V.dot(tangent)), 0.17, 0.34);
  return 1.0 - (1.0 - on_face) * Fading(push.distance, 0, -0.25);
}

std::optional<double> Thickness(const DistanceField& field, const Vec3& point_V,
                                const FieldPush& push) noexcept {
  constexpr double kStep = 0.25;      // voxels
  constexpr double kTold = 0.05;      // voxels by which the other side is nearer
  constexpr double kOpposite = -0.7;  // cosine between the sides' directions off
  for (double depth = kStep; depth < kThickest; depth += kStep) {
    const Vec3 place_V = point_V - (push.distance + depth) * push.away_V;
    FieldGradient other_side;
    field.WithGradients({&place_V, 1}, &other_side);
    if (!other_side.reading.near || other_side.reading.value < kTold - depth) continue;
    if (other_side.gradient.dot(push.away_V) > kOpposite * other_side.gradient.norm()) continue;
    const double thickness = depth - other_side.reading.value;
    return thickness < kThickest ? std::optional(thickness) : std::nullopt;
  }
  return {};
}

FieldPush Reversed(FieldPush push, double thickness) noexcept {
  push.distance = -(push.distance + thickness);
  push.away_V = -push.away_V;
  return push;
}

}  // namespace tandem
