// Feature points are compared with solids whose edges and corners are counted by hand.
#include "engine/contact/features/feature_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>

#include "engine/contact/pair/contact_kind.h"
#include "tests/engine/contact/refined.h"

namespace tandem {
namespace {

using testing::Box;
using testing::kS;
using testing::Sphere;

std::vector<FeaturePoint> PointsOf(const TriangleMesh& mesh_W) {
  const double flatness = FlatnessVoxels(ContactModel::kRefined) * kS;
  return FindFeaturePoints(mesh_W, FindFeatures(mesh_W, flatness), kS, 1.0);
}

double LengthOf(const std::vector<FeaturePoint>& points) {
  double length = 0;
  for (const FeaturePoint& point : points) length += 2 * point.half_length;
  return length;
}

/// Returns a prism along z, 10 voxels high, over an outline given counter-clockwise (voxels) that
/// is cut into triangles from its first corner.
TriangleMesh Prism(const std::vector<Vec3>& outline) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(outline.size());
  for (const double z : {0.0, 10.0}) {
    for (const Vec3& p : outline) mesh.vertices.push_back(kS * (p + Vec3(0, 0, z)));
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    mesh.triangles.push_back({i, j, n + j});
    mesh.triangles.push_back({i, n + j, n + i});
    if (i == 0 || j == 0) continue;
    mesh.triangles.push_back({0, j, i});
    mesh.triangles.push_back({n, n + i, n + j});
  }
  return mesh;
}

TEST(FeaturePoints, BoxHasItsCornersAndEdgesSampledPerVoxel) {
  const std::vector<FeaturePoint> points = PointsOf(Box(kS * Vec3(10.5, 6, 4)));
  const auto corners = std::count_if(points.begin(), points.end(), [](const FeaturePoint& p) {
    return !p.is_edge();
  });
  EXPECT_EQ(corners, 8);
  EXPECT_NEAR(LengthOf(points), 4 * (10.5 + 6 + 4), 1e-6);
  int ends = 0;
  for (const FeaturePoint& point : points) {
    EXPECT_LE(point.half_length, 0.5 + 1e-9);
    EXPECT_NEAR(point.outward.norm(), 1, 1e-9);
    EXPECT_GT(point.outward.dot(point.place_W), 0);  // the box stands round the origin
    if (!point.is_edge()) continue;
    EXPECT_NEAR(point.cosine, std::sqrt(0.5), 1e-9);
    if (!point.ends) continue;
    ++ends;
    // away from the corner, which is half a length behind
    const Vec3 corner = point.place_W - point.half_length * point.tangent;
    EXPECT_NEAR((corner.cwiseAbs() - Vec3(5.25, 3, 2)).norm(), 0, 1e-6);
  }
  EXPECT_EQ(ends, 24);
}

TEST(FeaturePoints, NotchesHaveNoFeaturePoints) {
  // an L: six corners, of which the inner one's edge along z is concave
  const TriangleMesh mesh =
      Prism({{0, 4, 0}, {0, 12, 0}, {-4, 12, 0}, {-4, 0, 0}, {4, 0, 0}, {4, 4, 0}});
  const std::vector<FeaturePoint> points = PointsOf(mesh);
  for (const FeaturePoint& point : points) {
    const bool on_notch = std::hypot(point.place_W.x(), point.place_W.y() - 4) < 1e-6;
    // only its ends, where edges of the two bases bulge
    EXPECT_FALSE(on_notch && point.is_edge());
  }
  const double bases = 2 * (4 + 8 + 4 + 12 + 8 + 4);
  EXPECT_NEAR(LengthOf(points), bases + 5 * 10, 1e-6);
}

TEST(FeaturePoints, FlatSubdivisionsHaveNoFeaturePoints) {
  TriangleMesh mesh = Box(kS * Vec3(8, 8, 8));
  // every face is cut into four times as many triangles, twice
  for (int times = 0; times < 2; ++times) {
    TriangleMesh finer;
    std::map<std::array<double, 3>, std::uint32_t> numbers;  // numbers by place
    const auto number = [&](const Vec3& p) {
      const auto [at, is_new] = numbers.try_emplace(
          {p.x(), p.y(), p.z()}, static_cast<std::uint32_t>(finer.vertices.size()));
      if (is_new) finer.vertices.push_back(p);
      return at->second;
    };
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const std::array<Vec3, 3> c{mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)};
      const std::array<Vec3, 3> m{0.5 * (c[0] + c[1]), 0.5 * (c[1] + c[2]), 0.5 * (c[2] + c[0])};
      const auto add = [&](const Vec3& p, const Vec3& q, const Vec3& r) {
        finer.triangles.push_back({number(p), number(q), number(r)});
      };
      add(c[0], m[0], m[2]);
      add(m[0], c[1], m[1]);
      add(m[2], m[1], c[2]);
      add(m[0], m[1], m[2]);
    }
    mesh = finer;
  }
  const std::vector<FeaturePoint> points = PointsOf(mesh);
  const auto corners = std::count_if(points.begin(), points.end(), [](const FeaturePoint& p) {
    return !p.is_edge();
  });
  EXPECT_EQ(corners, 8);
  EXPECT_NEAR(LengthOf(points), 12 * 8, 1e-6);
}

TEST(FeaturePoints, SpacingOnABallFollowsItsFacets) {
  // polygons of a quarter voxel either side span at most 2 sqrt(2 r 0.5) of a ball of radius r
  constexpr double kBall = 12;
  const std::vector<FeaturePoint> points = PointsOf(Sphere(kBall * kS, 4));
  const double span = 2 * std::sqrt(2 * kBall * 0.5);
  for (int i = 0; i < 500; ++i) {
    // a spiral over the sphere
    const double z = 1 - 2 * (i + 0.5) / 500;
    const double turn = 2.399963229728653 * i;
    const Vec3 place = kBall * Vec3(std::sqrt(1 - z * z) * std::cos(turn),
                                    std::sqrt(1 - z * z) * std::sin(turn), z);
    double nearest = 1e9;
    for (const FeaturePoint& point : points) {
      nearest = std::min(nearest, (point.place_W - place).norm());
    }
    EXPECT_LT(nearest, span);
  }
}

/// Returns how far a convex mesh stands out from its feature points, along the worst of many
/// directions, voxels. The plane that comes down along it is met so much late.
double MostStandingOut(const TriangleMesh& mesh_W) {
  const std::vector<FeaturePoint> points = PointsOf(mesh_W);
  std::mt19937_64 random(21);
  double most = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 way = testing::RandomDirection(random);
    double of_mesh = -1e9;
    double of_points = -1e9;
    for (const Vec3& v : mesh_W.vertices) of_mesh = std::max(of_mesh, way.dot(v) / kS);
    for (const FeaturePoint& p : points) of_points = std::max(of_points, way.dot(p.place_W));
    most = std::max(most, of_mesh - of_points);
  }
  return most;
}

// The polygons of features are flat to within a quarter of a voxel either side. A ball's vertices
// within them could stand out by 0.15 voxel, and force would begin so much late.
TEST(FeaturePoints, ConvexSurfacesStayWithinATwentiethOfAVoxel) {
  EXPECT_LT(MostStandingOut(Sphere(4 * kS, 3)), 0.05);
  EXPECT_LT(MostStandingOut(Sphere(10 * kS, 4)), 0.05);
  EXPECT_LT(MostStandingOut(Sphere(35 * kS, 5)), 0.05);
  EXPECT_LT(MostStandingOut(Sphere(80 * kS, 4)), 0.05);
  TriangleMesh egg = Sphere(20 * kS, 4);
  for (Vec3& v : egg.vertices) v = Vec3(0.4 * v.x(), 0.7 * v.y(), v.z());
  EXPECT_LT(MostStandingOut(egg), 0.05);
}

}  // namespace
}  // namespace tandem
