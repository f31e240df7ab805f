#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

Bounds BoundsOf(const TriangleMesh& mesh) {
  Bounds bounds;
  for (const TriangleMesh::Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) bounds.Add(mesh.vertices[vertex]);
  }
  return bounds;
}

double SurfaceArea(const TriangleMesh& mesh) {
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 side = mesh.corner(t, 1) - mesh.corner(t, 0);
    area += 0.5 * side.cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm();
  }
  return area;
}

TriangleMesh Transformed(const TriangleMesh& mesh, const Pose& X_WM) {
  TriangleMesh moved = mesh;
  for (Vec3& vertex : moved.vertices) vertex = X_WM * vertex;
  return moved;
}

void Append(TriangleMesh& whole, const TriangleMesh& part) {
  const auto offset = static_cast<std::uint32_t>(whole.vertices.size());
  whole.vertices.insert(whole.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const TriangleMesh::Triangle& t : part.triangles) {
    whole.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
}

}  // namespace tandem
