#pragma once

#include <string>

#include "tests/support/obj_text.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {

/// Returns four bars round a rectangular hole, 9 mm high (m). A key of 8 by 7 mm has so much play
/// in it, to each side.
inline TriangleMesh KeyholeMesh(double play) {
  constexpr double kOuter = 0.0125;
  constexpr double kHigh = 0.009;
  const double x = 0.004 + play;
  const double y = 0.0035 + play;
  TriangleMesh mesh = BoxBetween({-kOuter, -kOuter, 0}, {-x, kOuter, kHigh});
  Append(mesh, BoxBetween({x, -kOuter, 0}, {kOuter, kOuter, kHigh}));
  Append(mesh, BoxBetween({-x, -kOuter, 0}, {x, -y, kHigh}));
  Append(mesh, BoxBetween({-x, y, 0}, {x, kOuter, kHigh}));
  return mesh;
}

/// Returns a key of 8 by 7 by 50 mm that stands in that hole.
inline TriangleMesh KeyMesh() {
  return BoxBetween({-0.004, -0.0035, 0}, {0.004, 0.0035, 0.05});
}

/// Writes the two as a scene file with friction, for the demo: two hands lift the shared key by 60
/// mm in 3 s. Returns its path.
inline std::string WriteKeyScene(const ScratchFolder& folder, double play, double voxel_m) {
  folder.Write("hole.obj", ObjText(KeyholeMesh(play)));
  folder.Write("key.obj", ObjText(KeyMesh()));
  folder.Write("lift.json", R"({"waypoints": [
      {"t_s": 0, "p_W": [0, 0, 0], "q_xyzw": [0, 0, 0, 1]},
      {"t_s": 3, "p_W": [0, 0, 0.06], "q_xyzw": [0, 0, 0, 1]}]})");
  return folder
      .Write("key.json", R"({"name": "key", "friction": 0.2, "bodies": [
      {"name": "hole", "mesh": "hole.obj", "fixed": true},
      {"name": "key", "mesh": "key.obj", "mass_kg": 0.1, "sharing": "shared"}],
      "hands": [{"body": "key", "file": "lift.json"}, {"body": "key", "file": "lift.json"}],
      "voxel_m": )" + std::to_string(voxel_m) +
                             "}")
      .string();
}

}  // namespace tandem::testing
