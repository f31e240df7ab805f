#include "app/view/model/hand/part_picking.h"

#include <cmath>

namespace tandem {

namespace {

bool MeetsBox(const Ray& ray, const Bounds& box) {
  double enter = 0;
  double leave = 1e300;
  for (int axis = 0; axis < 3; ++axis) {
    const double along = ray.along_W[axis];
    if (std::abs(along) < 1e-15) {
      if (ray.from_W[axis] < box.min[axis] || ray.from_W[axis] > box.max[axis]) return false;
      continue;
    }
    const double a = (box.min[axis] - ray.from_W[axis]) / along;
    const double b = (box.max[axis] - ray.from_W[axis]) / along;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

/// Returns the distance along the ray to a triangle, seen from either side (Moeller and Trumbore).
std::optional<double> DistanceToTriangle(const Ray& ray, const Vec3& a, const Vec3& b,
                                         const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 ac = c - a;
  const Vec3 normal_to_both = ray.along_W.cross(ac);
  const double determinant = ab.dot(normal_to_both);
  if (std::abs(determinant) < 1e-30) return std::nullopt;
  const Vec3 from_a = ray.from_W - a;
  const double u = from_a.dot(normal_to_both) / determinant;
  if (u < 0 || u > 1) return std::nullopt;
  const Vec3 across = from_a.cross(ab);
  const double v = ray.along_W.dot(across) / determinant;
  if (v < 0 || u + v > 1) return std::nullopt;
  const double distance = ac.dot(across) / determinant;
  return distance > 0 ? std::optional(distance) : std::nullopt;
}

}  // namespace

std::optional<PartHit> PickPart(const Ray& ray, const DrawnScene& scene, const DrawList& list) {
  std::optional<PartHit> hit;
  double nearest = 1e300;
  for (const BodyInstance& solid : list.solids) {
    if (solid.body >= scene.bodies.size()) continue;
    const DrawnBody& body = scene.bodies[solid.body];
    // moves the ray to the body's first place, where its mesh is
    const Pose X_MW = solid.X_W.Inverse();
    const Ray ray_M{X_MW * ray.from_W, X_MW.q * ray.along_W};
    if (body.bounds_W.empty() || !MeetsBox(ray_M, body.bounds_W)) continue;
    const auto corner = [&body](std::uint32_t index) -> Vec3 {
      const auto& p = body.mesh.vertices[index].p;
      return {p[0], p[1], p[2]};
    };
    const auto& indices = body.mesh.triangles;
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
      const auto distance = DistanceToTriangle(ray_M, corner(indices[i]), corner(indices[i + 1]),
                                               corner(indices[i + 2]));
      if (!distance || *distance >= nearest) continue;
      nearest = *distance;
      hit = PartHit{solid.body, ray.from_W + nearest * ray.along_W};
    }
  }
  return hit;
}

}  // namespace tandem
