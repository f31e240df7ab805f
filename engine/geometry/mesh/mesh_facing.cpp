#include "engine/geometry/mesh/mesh_facing.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

namespace tandem {

namespace {

/// Returns 1 if a side runs from its lesser to its greater vertex, else -1.
int Direction(const TriangleMesh& mesh, std::uint32_t side) {
  const TriangleMesh::Triangle& t = mesh.triangles[side / 3];
  return t[side % 3] < t[(side % 3 + 1) % 3] ? 1 : -1;
}

/// Turns triangles so that those on the two sides of an edge run it in opposite directions.
void TurnToNeighbours(const MeshSides& sides, std::vector<std::int8_t>& facing) {
  std::unordered_map<std::uint32_t, std::uint32_t> against;  // per side: the triangle across
  for (const MeshSides::Wall& wall : sides.walls()) {
    if (wall.count != 2) continue;
    const std::uint32_t one = sides.wall_sides()[wall.first];
    const std::uint32_t two = sides.wall_sides()[wall.first + 1];
    against[one] = two / 3;
    against[two] = one / 3;
  }
  if (against.empty()) return;
  std::vector<std::uint8_t> seen(facing.size(), 0);
  std::vector<std::uint32_t> front;
  for (std::uint32_t seed = 0; seed < facing.size(); ++seed) {
    if (seen[seed] != 0) continue;
    seen[seed] = 1;
    front.assign(1, seed);
    while (!front.empty()) {
      const std::uint32_t t = front.back();
      front.pop_back();
      for (std::uint32_t k = 0; k < 3; ++k) {
        std::uint32_t other = sides.NeighborAcross(t, k);
        std::int8_t turn = 1;
        if (other == MeshSides::kNone) {
          const auto found = against.find(3 * t + k);
          if (found == against.end()) continue;
          other = found->second;
          turn = -1;
        }
        if (seen[other] != 0) continue;
        seen[other] = 1;
        facing[other] = static_cast<std::int8_t>(facing[t] * turn);
        front.push_back(other);
      }
    }
  }
}

}  // namespace

MeshFacing FindFacing(const TriangleMesh& mesh, const MeshSides& sides) {
  MeshFacing facing;
  facing.of_triangle.assign(mesh.triangles.size(), 1);
  TurnToNeighbours(sides, facing.of_triangle);

  std::vector<std::uint8_t> open(sides.bodies(), 0);  // per body
  bool any_open = false;
  for (const MeshSides::Wall& wall : sides.walls()) {
    int boundary = 0;
    for (std::uint32_t i = wall.first; i < wall.first + wall.count; ++i) {
      const std::uint32_t side = sides.wall_sides()[i];
      boundary += Direction(mesh, side) * facing.of_triangle[side / 3];
    }
    if (boundary == 0) continue;
    open[sides.BodyOf(sides.wall_sides()[wall.first] / 3)] = 1;
    any_open = true;
  }
  if (any_open) {
    facing.open.resize(mesh.triangles.size());
    for (std::size_t t = 0; t < facing.open.size(); ++t) facing.open[t] = open[sides.BodyOf(t)];
  }

  std::vector<double> volumes(sides.bodies(), 0.0);  // per body
  const Vec3 reference = mesh.triangles.empty() ? Vec3(Vec3::Zero()) : mesh.corner(0, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0) - reference;
    const Vec3 b = mesh.corner(t, 1) - reference;
    const Vec3 c = mesh.corner(t, 2) - reference;
    volumes[sides.BodyOf(t)] += a.dot(b.cross(c)) / 6.0 * facing.of_triangle[t];
  }
  bool any_inward = false;
  for (std::size_t b = 0; b < volumes.size(); ++b) {
    any_inward = any_inward || (volumes[b] < 0 && open[b] == 0);
  }
  if (!any_inward) return facing;
  std::vector<Bounds> boxes(sides.bodies());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) boxes[sides.BodyOf(t)].Add(mesh.corner(t, k));
  }
  std::vector<std::uint8_t> turned(sides.bodies(), 0);
  for (std::size_t b = 0; b < volumes.size(); ++b) {
    if (volumes[b] >= 0 || open[b] != 0) continue;
    turned[b] = 1;
    for (std::size_t outer = 0; outer < volumes.size() && turned[b] != 0; ++outer) {
      if (volumes[outer] > 0 && (boxes[outer].min.array() <= boxes[b].min.array()).all() &&
          (boxes[b].max.array() <= boxes[outer].max.array()).all()) {
        turned[b] = 0;
      }
    }
  }
  for (std::size_t t = 0; t < facing.of_triangle.size(); ++t) {
    if (turned[sides.BodyOf(t)] != 0) {
      facing.of_triangle[t] = static_cast<std::int8_t>(-facing.of_triangle[t]);
    }
  }
  return facing;
}

TriangleMesh OrientOutward(const TriangleMesh& mesh, const MeshFacing& facing) {
  TriangleMesh turned = mesh;
  for (std::size_t t = 0; t < turned.triangles.size(); ++t) {
    if (facing.of_triangle[t] < 0) std::swap(turned.triangles[t][1], turned.triangles[t][2]);
  }
  return turned;
}

}  // namespace tandem
