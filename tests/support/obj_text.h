#pragma once

#include <sstream>
#include <string>

#include "tests/support/solid_meshes.h"

namespace tandem::testing {

/// Returns the text of a mesh file in Wavefront's format, in the mesh's own units.
inline std::string ObjText(const TriangleMesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  for (const Vec3& v : mesh.vertices) {
    text << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  }
  for (const auto& t : mesh.triangles) {
    text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  }
  return text.str();
}

/// Returns the text for a box of these half sides about the origin.
inline std::string BoxObjText(double x, double y, double z) {
  return ObjText(BoxOfHalf({x, y, z}));
}

}  // namespace tandem::testing
