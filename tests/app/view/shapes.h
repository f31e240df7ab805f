#pragma once

#include <cmath>

#include "app/view/model/scene/drawn_scene.h"
#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// Returns a closed box, counter-clockwise from outside.
inline TriangleMesh BoxMesh(const Vec3& min, const Vec3& max) {
  TriangleMesh mesh;
  for (unsigned corner = 0; corner < 8; ++corner) {
    mesh.vertices.emplace_back((corner & 1U) != 0 ? max.x() : min.x(),
                               (corner & 2U) != 0 ? max.y() : min.y(),
                               (corner & 4U) != 0 ? max.z() : min.z());
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// Returns a closed sphere about the origin, of `rings` rings between two poles.
inline TriangleMesh SphereMesh(double radius, unsigned rings, unsigned around) {
  constexpr double kPi = 3.14159265358979323846;
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0, 0, radius);
  for (unsigned i = 1; i < rings; ++i) {
    const double polar = kPi * i / rings;
    for (unsigned j = 0; j < around; ++j) {
      const double turn = 2 * kPi * j / around;
      mesh.vertices.emplace_back(radius * std::sin(polar) * std::cos(turn),
                                 radius * std::sin(polar) * std::sin(turn),
                                 radius * std::cos(polar));
    }
  }
  mesh.vertices.emplace_back(0, 0, -radius);
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  const auto at = [&](unsigned i, unsigned j) {
    return 1 + (i - 1) * around + j % around;
  };
  for (unsigned j = 0; j < around; ++j) {
    mesh.triangles.push_back({0, at(1, j), at(1, j + 1)});
    for (unsigned i = 1; i + 1 < rings; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
    mesh.triangles.push_back({at(rings - 1, j), last, at(rings - 1, j + 1)});
  }
  return mesh;
}

/// Returns a grey block, fixed, with a green ball of 3 cm radius before it (at -Y) that moves.
inline DrawnScene BlockAndBall() {
  TriangleMesh ball = SphereMesh(0.03, 16, 32);
  for (Vec3& p : ball.vertices) p += Vec3(0, -0.1, 0);
  DrawnScene scene;
  scene.name = "block and ball";
  scene.digest = {7};
  scene.voxel_size = 0.001;
  scene.bodies.push_back(MakeDrawnBody("block", {true, {0.6F, 0.6F, 0.6F}},
                                       BoxMesh({-0.1, -0.02, -0.1}, {0.1, 0.02, 0.1})));
  scene.bodies.push_back(MakeDrawnBody("ball", {false, {0.1F, 0.8F, 0.1F}}, ball));
  return scene;
}

}  // namespace tandem
