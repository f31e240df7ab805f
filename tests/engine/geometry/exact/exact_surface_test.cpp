#include "engine/geometry/exact/exact_surface.h"

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/solid_meshes.h"

namespace tandem {
namespace {

using testing::BoxBetween;
using testing::BoxOfHalf;
using testing::GlobeMesh;
using testing::TurnedInsideOut;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double In(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Vec3 Point(double reach) { return {In(-reach, reach), In(-reach, reach), In(-reach, reach)}; }
  Pose Tilt(double reach) {
    return {Quat(In(-1, 1), In(-1, 1), In(-1, 1), In(-1, 1)).normalized(), Point(reach)};
  }

 private:
  std::mt19937 engine_;
};

// Returns the depth in a box centred at the origin, in closed form.
double BoxDepth(const Vec3& half, const Vec3& p) {
  const Vec3 beyond = p.cwiseAbs() - half;
  if ((beyond.array() < 0).all()) return -beyond.maxCoeff();
  return -beyond.cwiseMax(Vec3::Zero()).norm();
}

struct TiltedBox {
  Pose X_WBox;
  Vec3 half;
  double Depth(const Vec3& p_W) const { return BoxDepth(half, X_WBox.Inverse() * p_W); }
};

// Returns the distance to an axis-aligned rectangle: a box of no thickness.
double RectangleDistance(const Vec3& min, const Vec3& max, const Vec3& p) {
  return (p.cwiseMax(min).cwiseMin(max) - p).norm();
}

TEST(ExactSurface, DepthInATiltedBoxIsTheClosedForm) {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const TiltedBox box{random.Tilt(1), Vec3(0.2, 0.5, 0.9)};
    const ExactSurface surface(Transformed(BoxOfHalf(box.half), box.X_WBox));
    EXPECT_EQ(surface.facet_count(), 12U);
    for (int k = 0; k < 200; ++k) {
      const Vec3 p = box.X_WBox * random.Point(1.2);
      EXPECT_NEAR(surface.Depth(p), box.Depth(p), 1e-12);
    }
  }
}

TEST(ExactSurface, DepthInASphereIsTheClosedFormWithinItsFacetError) {
  const double radius = 0.7;
  const TriangleMesh sphere = GlobeMesh(radius, 48);
  // its vertices are on the sphere, the middles of its facets this far below
  double sag = 0;
  for (std::size_t t = 0; t < sphere.triangles.size(); ++t) {
    const Vec3& a = sphere.corner(t, 0);
    const Vec3 nhat = (sphere.corner(t, 1) - a).cross(sphere.corner(t, 2) - a).normalized();
    sag = std::max(sag, radius - nhat.dot(a));
  }
  const Pose tilt = Random(2).Tilt(1);
  const ExactSurface surface(Transformed(sphere, tilt));
  Random random(3);
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p = random.Point(1);
    const double exact = radius - p.norm();
    const double depth = surface.Depth(tilt * p);
    EXPECT_LE(depth, exact + 1e-12);
    EXPECT_GE(depth, exact - sag - 1e-12);
  }
}

TEST(ExactSurface, FaceOfOneBodyInsideAnotherDoesNotMakeDepthShallow) {
  // a cube with a bar through its face x = 1: the bar's inner end and the face's middle bound
  // nothing
  TriangleMesh mesh = BoxBetween(Vec3(-1, -1, -1), Vec3(1, 1, 1));
  Append(mesh, BoxBetween(Vec3(0, -0.5, -0.5), Vec3(3, 0.5, 0.5)));
  const ExactSurface surface(mesh);
  const auto boundary = [](const Vec3& p) {
    return std::min({RectangleDistance({-1, -1, -1}, {-1, 1, 1}, p),
                     RectangleDistance({-1, -1, -1}, {1, -1, 1}, p),
                     RectangleDistance({-1, 1, -1}, {1, 1, 1}, p),
                     RectangleDistance({-1, -1, -1}, {1, 1, -1}, p),
                     RectangleDistance({-1, -1, 1}, {1, 1, 1}, p),
                     // x = 1 without the bar's section
                     RectangleDistance({1, -1, -1}, {1, -0.5, 1}, p),
                     RectangleDistance({1, 0.5, -1}, {1, 1, 1}, p),
                     RectangleDistance({1, -1, -1}, {1, 1, -0.5}, p),
                     RectangleDistance({1, -1, 0.5}, {1, 1, 1}, p),
                     // the bar outside the cube
                     RectangleDistance({1, -0.5, -0.5}, {3, -0.5, 0.5}, p),
                     RectangleDistance({1, 0.5, -0.5}, {3, 0.5, 0.5}, p),
                     RectangleDistance({1, -0.5, -0.5}, {3, 0.5, -0.5}, p),
                     RectangleDistance({1, -0.5, 0.5}, {3, 0.5, 0.5}, p),
                     RectangleDistance({3, -0.5, -0.5}, {3, 0.5, 0.5}, p)});
  };
  const auto inside = [](const Vec3& p) {
    return p.cwiseAbs().maxCoeff() < 1 ||
           (p.x() > 0 && p.x() < 3 && std::abs(p.y()) < 0.5 && std::abs(p.z()) < 0.5);
  };
  // 0.1 under the covered face and 0.5 from the bar's covered sides, but sqrt(0.26) from the rim
  EXPECT_NEAR(surface.Depth({0.9, 0, 0}), std::sqrt(0.1 * 0.1 + 0.5 * 0.5), 1e-12);
  Random random(4);
  for (int k = 0; k < 3000; ++k) {
    const Vec3 p = random.Point(3.2);
    EXPECT_NEAR(surface.Depth(p), inside(p) ? boundary(p) : -boundary(p), 1e-9) << p.transpose();
  }
}

TEST(ExactSurface, BodiesThatTouchFaceToFaceAreOneSolid) {
  TriangleMesh mesh = BoxBetween(Vec3(0, 0, 0), Vec3(1, 1, 1));
  Append(mesh, BoxBetween(Vec3(1, 0, 0), Vec3(2, 1, 1)));  // the whole face in common
  Append(mesh,
         BoxBetween(Vec3(0.25, 0.25, 1), Vec3(1.75, 0.75, 2)));  // a part of two faces in common
  const ExactSurface surface(mesh);
  EXPECT_NEAR(surface.Depth({1, 0.5, 0.5}), 0.5, 1e-9);
  EXPECT_NEAR(surface.Depth({1, 0.4, 0.4}), 0.4, 1e-9);
  // on the interface of the boss; its rim is 0.25 away in y
  EXPECT_NEAR(surface.Depth({1, 0.5, 1}), 0.25, 1e-9);
  EXPECT_NEAR(surface.Depth({1, 0.5, 0.9}), std::hypot(0.25, 0.1), 1e-9);
  EXPECT_NEAR(surface.Depth({1, 0.1, 0.95}), 0.05, 1e-9);
}

TEST(ExactSurface, DepthIsTheLargestBallInAHeapOfTiltedBoxes) {
  Random random(5);
  std::vector<TiltedBox> boxes;
  TriangleMesh mesh;
  for (int i = 0; i < 25; ++i) {
    boxes.push_back({random.Tilt(0.7), Vec3(random.In(0.1, 0.5), random.In(0.1, 0.5), 0.3)});
    Append(mesh, Transformed(BoxOfHalf(boxes.back().half), boxes.back().X_WBox));
  }
  const auto inside = [&](const Vec3& p) {
    return std::any_of(boxes.begin(), boxes.end(), [&](const TiltedBox& box) {
      return box.Depth(p) > 0;
    });
  };
  const ExactSurface surface(mesh);
  int deep = 0;
  for (int k = 0; k < 600; ++k) {
    const Vec3 p = random.Point(1.2);
    const double depth = surface.Depth(p);
    ASSERT_EQ(depth > 0, inside(p)) << p.transpose();
    // the ball just within it is all of one kind …
    for (int i = 0; i < 30; ++i) {
      const Vec3 aside = random.Point(1).normalized() * std::abs(depth) * 0.99999;
      ASSERT_EQ(inside(p + aside), depth > 0) << p.transpose();
    }
    // … and at its closest point comes the other kind
    const Vec3 closest = surface.ClosestPoint(p);
    bool other = inside(closest + (closest - p).normalized() * 1e-5) != (depth > 0);
    for (int i = 0; i < 5000 && !other; ++i) {
      other = inside(closest + random.Point(1e-5)) != (depth > 0);
    }
    ASSERT_TRUE(other) << p.transpose();
    deep += depth > 0.1 ? 1 : 0;
  }
  EXPECT_GT(deep, 20);
}

TEST(ExactSurface, CavityIsOutsideAndACoreInItInside) {
  TriangleMesh mesh = BoxOfHalf(Vec3::Constant(1));
  Append(mesh, TurnedInsideOut(BoxOfHalf(Vec3::Constant(0.5))));
  Append(mesh, BoxOfHalf(Vec3::Constant(0.2)));
  const ExactSurface surface(mesh);
  EXPECT_NEAR(surface.Depth({0, 0, 0}), 0.2, 1e-12);
  EXPECT_NEAR(surface.Depth({0.3, 0, 0}), -0.1, 1e-12);
  EXPECT_NEAR(surface.Depth({0.6, 0, 0}), 0.1, 1e-12);
  EXPECT_NEAR(surface.Depth({1.5, 0, 0}), -0.5, 1e-12);
  EXPECT_FALSE(surface.Contains({0.4, 0.1, 0}));
}

TEST(ExactSurface, BodyTurnedInsideOutIsStillSolid) {
  TriangleMesh mesh = BoxOfHalf(Vec3::Constant(1));
  Append(mesh, Transformed(TurnedInsideOut(BoxOfHalf(Vec3::Constant(1))),
                           {Quat::Identity(), Vec3(5, 0, 0)}));
  const ExactSurface surface(mesh);
  EXPECT_NEAR(surface.Depth({5.2, 0, 0}), 0.8, 1e-12);
  EXPECT_NEAR(surface.Depth({0.2, 0, 0}), 0.8, 1e-12);
}

TEST(ExactSurface, CracksAtTJunctionsDoNotLeak) {
  // every face a grid of its own, each finer than the one before, with edges that do not match and
  // gape by up to a ten-thousandth
  Random random(6);
  TriangleMesh mesh;
  const TriangleMesh box = BoxOfHalf(Vec3::Constant(1));
  for (std::size_t t = 0; t < box.triangles.size(); ++t) {
    const Vec3 a = box.corner(t, 0);
    const Vec3 ab = box.corner(t, 1) - a;
    const Vec3 ac = box.corner(t, 2) - a;
    const auto n = static_cast<std::uint32_t>(3 + t);
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    const auto at = [&](std::uint32_t i, std::uint32_t k) {
      return base + i * (n + 1) + k;
    };
    for (std::uint32_t i = 0; i <= n; ++i) {
      for (std::uint32_t k = 0; k <= n; ++k) {
        mesh.vertices.emplace_back(a + ab * (double(i) / n) + ac * (double(k) / n) +
                                   random.Point(1e-4));
      }
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      for (std::uint32_t k = 0; i + k < n; ++k) {
        mesh.triangles.push_back({at(i, k), at(i + 1, k), at(i, k + 1)});
        if (i + k + 1 < n) mesh.triangles.push_back({at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)});
      }
    }
  }
  const ExactSurface surface(mesh);
  for (int k = 0; k < 3000; ++k) {
    const Vec3 p = random.Point(1.3);
    const double exact = BoxDepth(Vec3::Constant(1), p);
    if (std::abs(exact) < 1e-3) continue;
    EXPECT_NEAR(surface.Depth(p), exact, 2e-4) << p.transpose();
  }
}

TEST(ExactSurface, SheetEnclosesNothing) {
  TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const ExactSurface alone(sheet);
  EXPECT_TRUE(alone.empty());
  EXPECT_LT(alone.Depth({0.5, 0.5, -1e-6}), -1e300);
  EXPECT_TRUE(ExactSurface(TriangleMesh{}).empty());

  Append(sheet, BoxBetween(Vec3(2, 0, -1), Vec3(3, 1, 1)));
  const ExactSurface beside_a_box(sheet);
  for (const double z : {-1e-3, -1e-7, 0.0, 1e-7, 1e-3}) {
    EXPECT_NEAR(beside_a_box.Depth({0.5, 0.6, z}), -1.5, 1e-9) << z;
  }
}

TEST(ExactSurface, HintsChangeNothing) {
  Random random(7);
  TriangleMesh mesh = GlobeMesh(0.6, 24);
  Append(mesh, BoxBetween(Vec3(0, -0.3, -0.2), Vec3(1, 0.3, 0.2)));
  const ExactSurface surface(mesh);
  for (int k = 0; k < 1000; ++k) {
    const Vec3 p = random.Point(1.1);
    const double depth = surface.Depth(p);
    ExactSurface::Hint hint{.at_most = std::abs(depth)};
    EXPECT_EQ(surface.Depth(p, hint), depth);
    hint.side = depth > 0 ? ExactSurface::Side::kInside : ExactSurface::Side::kOutside;
    EXPECT_EQ(surface.Depth(p, hint), depth);
    EXPECT_EQ(surface.Distance(p), std::abs(depth));
    EXPECT_EQ(surface.Distance(p, 0.5 * std::abs(depth)), 0.5 * std::abs(depth));
  }
}

// A triangle whose points are inside and outside meets the surface; one that is farther from it
// than its points are from one another does not.
TEST(ExactSurface, TriangleMeetsItWhereItsPointsLieOnBothSides) {
  Random random(9);
  TriangleMesh mesh = GlobeMesh(0.6, 24);
  Append(mesh, BoxBetween(Vec3(0, -0.3, -0.2), Vec3(1, 0.3, 0.2)));
  const ExactSurface surface(mesh);
  constexpr int kSteps = 20;
  int meet = 0;
  int apart = 0;
  for (int k = 0; k < 1000; ++k) {
    const Vec3 a = random.Point(0.9);
    const Vec3 ab = random.Point(0.3);
    const Vec3 ac = random.Point(0.3);
    double least = std::numeric_limits<double>::infinity();
    double most = -least;
    double nearest = least;
    for (int i = 0; i <= kSteps; ++i) {
      for (int j = 0; i + j <= kSteps; ++j) {
        const double depth = surface.Depth(a + ab * i / kSteps + ac * j / kSteps);
        least = std::min(least, depth);
        most = std::max(most, depth);
        nearest = std::min(nearest, std::abs(depth));
      }
    }
    const bool may_meet = surface.MayMeet({a, a + ab, a + ac});
    if (least < -1e-6 && most > 1e-6) {
      EXPECT_TRUE(may_meet) << k;
      ++meet;
    } else if (nearest > (ab.norm() + ac.norm()) / kSteps) {
      EXPECT_FALSE(may_meet) << k;
      ++apart;
    }
  }
  EXPECT_GT(meet, 100);
  EXPECT_GT(apart, 100);
  EXPECT_FALSE(ExactSurface(TriangleMesh()).MayMeet({Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()}));
}

TEST(WindingNumber, CountsBodiesAroundAPoint) {
  TriangleMesh mesh = GlobeMesh(1, 48);
  Append(mesh, Transformed(GlobeMesh(1, 40), {Quat::Identity(), Vec3(0.8, 0, 0)}));
  const WindingNumber winding(mesh);
  Random random(8);
  for (int k = 0; k < 100; ++k) {
    const Vec3 p = random.Point(2);
    double exact = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      exact += WindingOf(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), p);
    }
    EXPECT_NEAR(exact, std::round(exact), 1e-9);
    EXPECT_NEAR(winding.At(p), exact, 0.05);
  }
}

}  // namespace
}  // namespace tandem
