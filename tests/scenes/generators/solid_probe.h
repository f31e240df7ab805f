#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Answers for points against a solid of closed bodies that do not overlap, straight from its
/// triangles.
class SolidProbe {
 public:
  /// Finds distances up to `reach`, in the mesh's unit.
  SolidProbe(const TriangleMesh& mesh, double reach);

  /// Judges by the parity of a ray along +z.
  bool Inside(const Vec3& p) const;
  /// Returns the distance to the nearest triangle; `reach` when there is none so near.
  double Distance(const Vec3& p) const;

 private:
  using Cells = std::unordered_map<std::uint64_t, std::vector<std::uint32_t>>;
  static std::uint64_t Key(std::int64_t i, std::int64_t j, std::int64_t k);

  TriangleMesh mesh_;
  double reach_;
  std::vector<Bounds> boxes_;  // boxes round the triangles
  Cells near_;                 // triangles by the cells that they come within reach of
  Cells columns_;              // and by the columns along z that they cross
};

/// Returns points on the triangles: every point of them has one within `spacing`, and no cube of
/// half that edge holds two.
std::vector<Vec3> SurfaceSamples(const TriangleMesh& mesh, double spacing);

/// Returns the centre of the enclosed volume.
Vec3 VolumeCentre(const TriangleMesh& mesh);

/// Returns whether every directed edge is there once, and so is its opposite, and the volume is
/// above 0.
bool ClosedAndTurnedOutward(const TriangleMesh& mesh);

}  // namespace tandem
