#include "engine/field/build/field_mesh.h"

#include "engine/field/build/field_faces.h"

namespace tandem {

FieldMesh::FieldMesh(const TriangleMesh& mesh_W, const MeshFacing& facing, double voxel_size)
    : surface_(mesh_W, Features{}, voxel_size, facing, 1),
      inside_(surface_, mesh_W, facing, voxel_size),
      open_(!facing.open.empty()),
      faces_(FindFieldFaces(mesh_W, facing, voxel_size, origin())),
      tree_(faces_) {}

bool FieldMesh::Solid(const GridIndex& voxel_V) const {
  const HyperchunkBox& box = surface_.box();
  const GridIndex hyperchunk = (voxel_V >> 6) + box.first;
  if (!box.Holds(hyperchunk)) return false;
  const std::size_t cell = box.CellOf(hyperchunk);
  const std::uint64_t* rows = inside_.RowsOf(cell);
  if (rows == nullptr) return inside_.Solid(cell);
  const auto row = static_cast<std::size_t>((voxel_V.y & 63) + 64 * (voxel_V.z & 63));
  return (rows[row] >> (voxel_V.x & 63) & 1U) != 0;
}

Bounds BoundsOfFace(const FieldFace& face) {
  Bounds box;
  for (const Vec3& corner : face.corners_L) box.Add(corner);
  return box;
}

}  // namespace tandem
