#include "tests/support/shapes.h"

#include <map>
#include <utility>

namespace tandem::testing {

TriangleMesh Box(const Vec3& size) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    mesh.vertices.push_back(
        size.cwiseProduct(Vec3(corner & 1, corner >> 1 & 1, corner >> 2) - Vec3::Constant(0.5)));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TriangleMesh Sphere(double radius, int levels) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3::UnitX(),  -Vec3::UnitX(), Vec3::UnitY(),
                   -Vec3::UnitY(), Vec3::UnitZ(),  -Vec3::UnitZ()};
  mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                    {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, added] = middles.try_emplace(std::minmax(a, b), mesh.vertices.size());
      if (added) {
        mesh.vertices.push_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      }
      return it->second;
    };
    std::vector<TriangleMesh::Triangle> finer;
    for (const auto& t : mesh.triangles) {
      const std::uint32_t ab = middle(t[0], t[1]);
      const std::uint32_t bc = middle(t[1], t[2]);
      const std::uint32_t ca = middle(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vec3& vertex : mesh.vertices) vertex *= radius;
  return mesh;
}

TriangleMesh HollowBlock(double side, double radius) {
  TriangleMesh mesh = Box(Vec3::Constant(side));
  const TriangleMesh hollow = Sphere(radius, 4);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), hollow.vertices.begin(), hollow.vertices.end());
  for (const auto& triangle : hollow.triangles) {
    mesh.triangles.push_back({first + triangle[0], first + triangle[2], first + triangle[1]});
  }
  return mesh;
}

TriangleMesh Raised(const std::vector<std::array<double, 2>>& polygon, double height, double unit) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(polygon.size());
  for (const double z : {0.0, height}) {
    for (const auto& [x, y] : polygon) mesh.vertices.emplace_back(unit * Vec3(x, y, z));
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t next = (k + 1) % n;
    if (k > 0 && k + 1 < n) {
      mesh.triangles.push_back({0, k + 1, k});
      mesh.triangles.push_back({n, n + k, n + k + 1});
    }
    mesh.triangles.push_back({k, next, n + next});
    mesh.triangles.push_back({k, n + next, n + k});
  }
  return mesh;
}

TriangleMesh Sheet(double side) {
  TriangleMesh mesh;
  const double h = 0.5 * side;
  mesh.vertices = {{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

double Uniform(std::mt19937_64& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random() >> 11U) * 0x1p-53;
}

Quat RandomRotation(std::mt19937_64& random) {
  Quat q;
  do {
    for (int k = 0; k < 4; ++k) q.coeffs()[k] = Uniform(random, -1, 1);
  } while (q.norm() > 1 || q.norm() < 0.1);
  return q.normalized();
}

Vec3 RandomDirection(std::mt19937_64& random) {
  return RandomRotation(random) * Vec3::UnitX();
}

}  // namespace tandem::testing
