#include "engine/geometry/exact/bodies_meeting.h"

#include <cstdint>
#include <vector>

#include "engine/geometry/mesh/mesh_diagnosis.h"

namespace tandem {

TriangleMesh BodiesMeeting(const TriangleMesh& mesh, const Bounds& box) {
  const MeshDiagnosis diagnosis = Diagnose(mesh);
  if (!diagnosis.closed()) return mesh;
  std::vector<Bounds> boxes(diagnosis.bodies);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Bounds& of_body = boxes[diagnosis.body_of_triangle[t]];
    for (std::size_t k = 0; k < 3; ++k) of_body.Add(mesh.corner(t, k));
  }
  constexpr std::uint32_t kUnused = ~0U;
  std::vector<std::uint32_t> number(mesh.vertices.size(), kUnused);
  TriangleMesh met;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!boxes[diagnosis.body_of_triangle[t]].Overlaps(box)) continue;
    TriangleMesh::Triangle kept = mesh.triangles[t];
    for (std::uint32_t& corner : kept) {
      std::uint32_t& place = number[corner];
      if (place == kUnused) {
        place = static_cast<std::uint32_t>(met.vertices.size());
        met.vertices.push_back(mesh.vertices[corner]);
      }
      corner = place;
    }
    met.triangles.push_back(kept);
  }
  return met;
}

}  // namespace tandem
