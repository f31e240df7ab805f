#include "engine/geometry/mesh/round_surfaces.h"

#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/round_shapes.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Arc;
using testing::PrismAlongY;

// as for voxels of 1 mm
constexpr RoundSurfaceRules kRules{
    .most_sagitta = 0.05e-3, .most_off = 0.01e-3, .least_radius = 1e-3};
constexpr double kWhole = 2 * std::numbers::pi;

bool HasNone(const TriangleMesh& mesh) {
  return FindRoundSurfaces(mesh, kRules).empty();
}

TEST(RoundSurfaces, FindsABallWithItsCentreAndRadius) {
  const Vec3 centre(0.03, -0.02, 0.5);
  const auto found = FindRoundSurfaces(testing::At(testing::Sphere(0.01, 4), centre), kRules);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].is_sphere());
  EXPECT_LT((found[0].centre - centre).norm(), 1e-9);
  EXPECT_NEAR(found[0].radius, 0.01, 1e-9);
}

TEST(RoundSurfaces, FindsACylinderWithItsAxis) {
  const Quat q = RotationBy(Vec3(0.3, -0.8, 0.5));
  const Vec3 centre(0.03, -0.02, 0.5);
  for (const std::uint32_t rings : {1U, 5U}) {
    const auto found =
        FindRoundSurfaces(testing::At(testing::Cylinder(0.01, 0.03, 64, rings), centre, q), kRules);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_FALSE(found[0].is_sphere());
    EXPECT_LT((found[0].centre - centre).norm(), 1e-8);
    EXPECT_NEAR(std::abs(found[0].axis.dot(q * Vec3::UnitY())), 1.0, 1e-9);
    EXPECT_NEAR(found[0].half_length, 0.015, 1e-8);
    EXPECT_NEAR(found[0].radius, 0.01, 1e-8);
    EXPECT_NEAR(found[0].sagitta, 0.01 * (1 - std::cos(kWhole / 128)), 1e-8);
  }
}

TEST(RoundSurfaces, ABoxHasNone) {
  EXPECT_TRUE(HasNone(testing::Box(Vec3(0.02, 0.03, 0.01))));
}

// An octahedron's corners lie on a sphere too, but it does not roll like one.
TEST(RoundSurfaces, ACoarseSolidIsNoBall) {
  EXPECT_TRUE(HasNone(testing::Sphere(0.01, 1)));
}

// Small ones too, whose sides lie close under the circle.
TEST(RoundSurfaces, APrismIsNoCylinder) {
  for (const double radius : {0.0012, 0.002, 0.003, 0.01}) {
    for (const std::uint32_t sides : {6U, 12U, 15U, 16U}) {
      EXPECT_TRUE(HasNone(testing::Cylinder(radius, 0.02, sides)))
          << radius << ", " << sides << " sides";
    }
  }
}

// A flat of so many degrees among sides of 4 or 10 degrees. Its borders may be sharp or smooth.
// Flats less than 0.03 mm deep are none: contact itself is no finer.
TEST(RoundSurfaces, AShaftWithAFlatIsNoCylinder) {
  for (const double radius : {0.0012, 0.0025, 0.01}) {
    for (const double flat : {24.0, 32.0, 60.0, 120.0}) {
      for (const double side : {4.0, 10.0}) {
        const double begin = 0.5 * flat * kWhole / 360;
        if (radius * (1 - std::cos(begin)) < 0.03e-3) continue;
        const auto count = static_cast<std::uint32_t>((360 - flat) / side);
        auto corners = Arc(radius, count, begin, kWhole - begin);
        corners.push_back({radius * std::cos(begin), -radius * std::sin(begin)});
        EXPECT_TRUE(HasNone(PrismAlongY(corners, 0.02)))
            << radius << ", flat of " << flat << " degrees, sides of " << side;
      }
    }
  }
}

TEST(RoundSurfaces, AShaftWithAKeywayIsNoCylinder) {
  for (const double open : {4.0, 18.0, 40.0}) {
    const double begin = 0.5 * open * kWhole / 360;
    constexpr double kRadius = 0.01;
    auto corners = Arc(kRadius, 90, begin, kWhole - begin);
    corners.push_back({kRadius * std::cos(begin), -kRadius * std::sin(begin)});
    const double deep = 0.7;
    corners.push_back({deep * kRadius * std::cos(begin), -deep * kRadius * std::sin(begin)});
    corners.push_back({deep * kRadius * std::cos(begin), deep * kRadius * std::sin(begin)});
    EXPECT_TRUE(HasNone(PrismAlongY(corners, 0.03))) << open;
  }
}

// The triangles about a place of the side are missing, few or many.
TEST(RoundSurfaces, ACylinderWithACrossHoleIsNone) {
  for (const double hole : {0.0015, 0.004}) {
    TriangleMesh mesh = testing::Cylinder(0.01, 0.03, 64, 30);
    const std::size_t before = mesh.triangles.size();
    std::erase_if(mesh.triangles, [&](const auto& triangle) {
      const Vec3 middle =
          (mesh.vertices[triangle[0]] + mesh.vertices[triangle[1]] + mesh.vertices[triangle[2]]) /
          3;
      return middle.z() > 0 && std::hypot(middle.x(), middle.y()) < hole;
    });
    ASSERT_LT(mesh.triangles.size(), before);
    EXPECT_TRUE(HasNone(mesh)) << hole;
  }
}

// A round pocket in a plate bends the other way. The search finds it: it does not tell which side
// is solid.
TEST(RoundSurfaces, FindsAHollowToo) {
  EXPECT_EQ(FindRoundSurfaces(testing::HollowBlock(0.03, 0.01), kRules).size(), 1U);
}

}  // namespace
}  // namespace tandem
