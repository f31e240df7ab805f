#include "engine/geometry/mesh_facing.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>

namespace tandem {

namespace {

/// The body of each triangle: the number of its least vertex.
std::vector<std::uint32_t> Bodies(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto find = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::uint32_t i = find(a);
    const std::uint32_t j = find(b);
    const std::uint32_t k = find(c);
    const std::uint32_t least = std::min({i, j, k});
    parent[i] = parent[j] = parent[k] = least;
  }
  std::vector<std::uint32_t> bodies(mesh.triangles.size());
  for (std::size_t t = 0; t < bodies.size(); ++t) bodies[t] = find(mesh.triangles[t][0]);
  return bodies;
}

/// 1 if a side runs from its lesser to its greater vertex, else -1.
int Direction(const TriangleMesh& mesh, std::uint32_t side) {
  const TriangleMesh::Triangle& t = mesh.triangles[side / 3];
  return t[side % 3] < t[(side % 3 + 1) % 3] ? 1 : -1;
}

/// Turns triangles so that those on the two sides of an edge run it in opposite directions.
void TurnToNeighbours(const MeshSides& sides, std::vector<std::int8_t>& facing) {
  std::unordered_map<std::uint32_t, std::uint32_t> against;  // by side: the triangle across
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
        std::uint32_t other = sides.Across(t, k);
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
  const std::vector<std::uint32_t> body_of = Bodies(mesh);

  std::vector<std::uint8_t> open(mesh.vertices.size(), 0);  // by body
  bool any_open = false;
  for (const MeshSides::Wall& wall : sides.walls()) {
    int boundary = 0;
    for (std::uint32_t i = wall.first; i < wall.first + wall.count; ++i) {
      const std::uint32_t side = sides.wall_sides()[i];
      boundary += Direction(mesh, side) * facing.of_triangle[side / 3];
    }
    if (boundary == 0) continue;
    open[body_of[sides.wall_sides()[wall.first] / 3]] = 1;
    any_open = true;
  }
  if (any_open) {
    facing.open.resize(mesh.triangles.size());
    for (std::size_t t = 0; t < facing.open.size(); ++t) facing.open[t] = open[body_of[t]];
  }

  std::vector<double> volumes(mesh.vertices.size(), 0.0);  // by body
  const Vec3 reference = BoundsOf(mesh).centre();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0) - reference;
    const Vec3 b = mesh.corner(t, 1) - reference;
    const Vec3 c = mesh.corner(t, 2) - reference;
    volumes[body_of[t]] += a.dot(b.cross(c)) / 6.0 * facing.of_triangle[t];
  }
  std::vector<std::uint32_t> bodies;
  bool any_inward = false;
  for (std::uint32_t v = 0; v < volumes.size(); ++v) {
    if (volumes[v] == 0) continue;
    bodies.push_back(v);
    any_inward = any_inward || (volumes[v] < 0 && open[v] == 0);
  }
  if (!any_inward) return facing;
  std::vector<Bounds> boxes(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) boxes[body_of[t]].Add(mesh.corner(t, k));
  }
  std::vector<std::uint8_t> turned(mesh.vertices.size(), 0);
  for (const std::uint32_t b : bodies) {
    if (volumes[b] > 0 || open[b] != 0) continue;
    turned[b] = std::none_of(bodies.begin(), bodies.end(), [&](std::uint32_t outer) {
      return volumes[outer] > 0 && (boxes[outer].min.array() <= boxes[b].min.array()).all() &&
             (boxes[b].max.array() <= boxes[outer].max.array()).all();
    });
  }
  for (std::size_t t = 0; t < facing.of_triangle.size(); ++t) {
    if (turned[body_of[t]] != 0) {
      facing.of_triangle[t] = static_cast<std::int8_t>(-facing.of_triangle[t]);
    }
  }
  return facing;
}

}  // namespace tandem
