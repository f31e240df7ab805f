#include "engine/geometry/mesh/facets.h"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Sheet;
using testing::Sphere;

/// Returns a closed cylinder about z, its caps fans round a middle vertex.
TriangleMesh Cylinder(double radius, double length, std::uint32_t sides) {
  TriangleMesh mesh;
  for (const double z : {0.0, length}) {
    for (std::uint32_t i = 0; i < sides; ++i) {
      const double a = 2 * M_PI * i / sides;
      mesh.vertices.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
    }
  }
  mesh.vertices.emplace_back(0, 0, 0);
  mesh.vertices.emplace_back(0, 0, length);
  for (std::uint32_t i = 0; i < sides; ++i) {
    const std::uint32_t j = (i + 1) % sides;
    mesh.triangles.push_back({i, j, sides + j});
    mesh.triangles.push_back({i, sides + j, sides + i});
    mesh.triangles.push_back({j, i, 2 * sides});
    mesh.triangles.push_back({sides + i, sides + j, 2 * sides + 1});
  }
  return mesh;
}

/// Returns a box whose faces are cut into n x n squares.
TriangleMesh CutBox(double side, int n) {
  TriangleMesh mesh;
  std::map<std::array<int, 3>, std::uint32_t> numbers;
  const auto vertex = [&](std::array<int, 3> at) {
    const auto [it, added] = numbers.emplace(at, static_cast<std::uint32_t>(mesh.vertices.size()));
    if (added) mesh.vertices.push_back(side / n * Vec3(at[0], at[1], at[2]));
    return it->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const int level : {0, n}) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const auto at = [&](int u, int v) {
            std::array<int, 3> p{};
            p[axis] = level;
            p[(axis + 1) % 3] = u;
            p[(axis + 2) % 3] = v;
            return vertex(p);
          };
          const std::uint32_t a = at(i, j);
          const std::uint32_t b = at(i + 1, j);
          const std::uint32_t c = at(i + 1, j + 1);
          const std::uint32_t d = at(i, j + 1);
          if (level == 0) {
            mesh.triangles.push_back({a, c, b});
            mesh.triangles.push_back({a, d, c});
          } else {
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
          }
        }
      }
    }
  }
  return mesh;
}

/// Returns the farthest that a polygon's vertices lie from its area-weighted mean plane, found
/// anew.
double WorstHeight(const TriangleMesh& mesh, const Features& features) {
  std::vector<Vec3> area(features.polygons, Vec3::Zero());
  std::vector<Vec3> moment(features.polygons, Vec3::Zero());
  std::vector<double> weight(features.polygons, 0);
  const auto area_of = [&](std::size_t t) {
    return Vec3(
        (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)));
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t p = features.polygon_of[t];
    area[p] += area_of(t);
    moment[p] +=
        area_of(t).norm() / 3 * (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2));
    weight[p] += area_of(t).norm();
  }
  double worst = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t p = features.polygon_of[t];
    EXPECT_GT(area_of(t).dot(area[p]), 0) << "a triangle turned 90 degrees or more";
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 from_middle = mesh.corner(t, k) - moment[p] / weight[p];
      worst = std::max(worst, std::abs(from_middle.dot(area[p].normalized())));
    }
  }
  return worst;
}

TEST(Facets, SubdividedBoxHasSixPolygons) {
  for (const int n : {1, 7, 30}) {
    const Features features = FindFeatures(CutBox(1.0, n), 0.005);
    EXPECT_EQ(features.polygons, 6U);
    EXPECT_EQ(features.edges.size(), 12U * static_cast<std::size_t>(n));
    EXPECT_EQ(features.vertices.size(), 8U);
  }
}

// Neighbour by neighbour all of a fine cylinder's side is flat; as a whole it is not.
TEST(Facets, FineCylinderIsNotMergedIntoOnePolygon) {
  for (const std::uint32_t sides : {90U, 720U, 5000U}) {
    const TriangleMesh mesh = Cylinder(1.0, 3.0, sides);
    const double tolerance = 0.01;
    const Features features = FindFeatures(mesh, tolerance);
    EXPECT_LE(WorstHeight(mesh, features), tolerance * 1.000001);
    // a strip within +-0.01 of its plane is at most 2 acos(0.98) wide, 23 degrees: no fewer than
    // 16 strips and two caps; growing both ways from a seed they come out nearly as wide
    EXPECT_GE(features.polygons, 18U);
    EXPECT_LE(features.polygons, 40U);
    EXPECT_LT(features.edges.size(), 3U * sides);  // the mesh has 6 n edges
    // on each rim one where each two strips meet, and one more where an arc leaves its chord
    EXPECT_GE(features.vertices.size(), 2 * (features.polygons - 2));
    EXPECT_LE(features.vertices.size(), 4 * (features.polygons - 2));
  }
}

TEST(Facets, ATinyBallKeepsSeveralPolygons) {
  const TriangleMesh mesh = Sphere(0.1, 4);
  const Features features = FindFeatures(mesh, 1.0);  // all of it within the tolerance
  EXPECT_GE(features.polygons, 2U);
  EXPECT_LE(WorstHeight(mesh, features), 1.0);
}

// Two polygons alone meet there along a curve that stays within tolerance of its chord.
TEST(Facets, SmoothRimHasVerticesOnlyWhereItLeavesItsChord) {
  // two square sheets that meet at 60 degrees along a gently waving line of 200 edges
  TriangleMesh mesh;
  const std::uint32_t n = 200;
  const auto build = [&](double wave) {
    mesh = {};
    for (std::uint32_t i = 0; i <= n; ++i) {
      const double x = static_cast<double>(i) / n;
      const double y = wave * std::sin(2 * M_PI * x);
      mesh.vertices.emplace_back(x, y - 1, 0);
      mesh.vertices.emplace_back(x, y, 0);
      mesh.vertices.emplace_back(x, y + 0.5, 0.8);
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      for (const std::uint32_t row : {0U, 1U}) {
        const std::uint32_t a = 3 * i + row;
        mesh.triangles.push_back({a, a + 3, a + 4});
        mesh.triangles.push_back({a, a + 4, a + 1});
      }
    }
    return FindFeatures(mesh, 0.01);
  };
  const auto on_line = [&](const Features& features) {
    std::size_t count = 0;
    for (const std::uint32_t v : features.vertices) count += v % 3 == 1;
    return count;
  };
  const Features smooth = build(0.004);
  EXPECT_EQ(smooth.polygons, 2U);
  EXPECT_EQ(on_line(smooth), 2U);  // its ends
  const std::size_t waving = on_line(build(0.02));
  EXPECT_GT(waving, 2U);
  EXPECT_LT(waving, 10U);
}

TEST(Facets, OpenAndNonManifoldEdgesAreFeatures) {
  const Features sheet = FindFeatures(Sheet(1.0), 0.01);
  EXPECT_EQ(sheet.polygons, 1U);
  EXPECT_EQ(sheet.edges.size(), 4U);
  EXPECT_EQ(sheet.vertices.size(), 4U);
  TriangleMesh fin = Sheet(1.0);  // a third triangle on the diagonal, in the same plane
  const TriangleMesh::Triangle first = fin.triangles[0];
  fin.vertices.emplace_back(0.0, 0.0, 0.0);
  fin.triangles.push_back(
      {first[0], first[1], static_cast<std::uint32_t>(fin.vertices.size() - 1)});
  fin.triangles.push_back(
      {first[1], first[2], static_cast<std::uint32_t>(fin.vertices.size() - 1)});
  fin.triangles.push_back(
      {first[2], first[0], static_cast<std::uint32_t>(fin.vertices.size() - 1)});
  const Features with_fin = FindFeatures(fin, 0.01);
  EXPECT_GT(with_fin.edges.size(), 4U);
}

TEST(Facets, AreDeterministic) {
  const TriangleMesh mesh = Sphere(1.0, 5);
  const Features one = FindFeatures(mesh, 0.01);
  const Features two = FindFeatures(mesh, 0.01);
  EXPECT_EQ(one.polygon_of, two.polygon_of);
  EXPECT_EQ(one.edges, two.edges);
  EXPECT_EQ(one.vertices, two.vertices);
  EXPECT_LE(WorstHeight(mesh, one), 0.01 * 1.000001);
}

}  // namespace
}  // namespace tandem
