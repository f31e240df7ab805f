// Tests pushes off surfaces whose ways are known in closed form.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include "engine/contact/pair/tangent_plane.h"
#include "engine/field/build/field_builder.h"
#include "engine/geometry/mesh/closest_on_triangle.h"
#include "tests/engine/field/brute_distance.h"
#include "tests/engine/field/query/built_field.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Box;
using testing::BruteDistance;
using testing::BuiltField;
using testing::HollowBlock;
using testing::InVoxels;
using testing::kReach;
using testing::kVoxelSize;
using testing::Notch;
using testing::Raised;
using testing::RandomRotation;
using testing::Sphere;
using testing::Uniform;

using Pushes = std::vector<FieldPush>;

Pushes PushesAt(const DistanceField& field, const Vec3& place) {
  FieldPushes pushes;
  field.Pushes({&place, 1}, kReach, pushes);
  return {pushes.PushesAt(0).begin(), pushes.PushesAt(0).end()};
}

/// Returns the sum of the pushes, in voxels of depth.
Vec3 SumOf(std::span<const FieldPush> pushes) {
  Vec3 sum = Vec3::Zero();
  for (const FieldPush& push : pushes) {
    sum += (kReach - push.distance) * push.share * push.away_V;
  }
  return sum;
}

/// Returns the force that they come to, where contact is as stiff as a voxel is deep.
Vec3 ForceOf(std::span<const FieldPush> pushes) {
  constexpr double kSoft = 0.1;  // voxels over which stiffness grows
  Vec3 sum = Vec3::Zero();
  for (const FieldPush& push : pushes) {
    sum += ContactForce(push.share, kReach - push.distance, 1.0, kSoft) * push.away_V;
  }
  return sum;
}

/// The force along a straight way through places outside a body.
struct Slide {
  double largest = 0;  // greatest change of the force from one step to the next
  int pushed = 0;      // steps with a force
};

/// Reads the force at `steps` places from `from` on, each `step` voxels farther along `way`.
Slide SlideAlong(const DistanceField& field, const Vec3& from, const Vec3& way, double step,
                 std::size_t steps) {
  Slide slide;
  Vec3 last = Vec3::Zero();
  bool outside = false;
  std::array<Vec3, FieldPushes::kMostPlaces> places;
  FieldPushes pushes;
  for (std::size_t i = 0; i < steps; i += places.size()) {
    for (std::size_t k = 0; k < places.size(); ++k) {
      const double along = step * static_cast<double>(i + k);
      places[k] = InVoxels(field, kVoxelSize * (from + along * way));
    }
    field.Pushes(places, kReach, pushes);
    for (std::size_t k = 0; k < places.size(); ++k) {
      const Vec3 sum = ForceOf(pushes.PushesAt(k));
      const bool now = field.At(places[k]).value > 0.02;
      if (outside && now) slide.largest = std::max(slide.largest, (sum - last).norm());
      slide.pushed += now && sum.norm() > 0.01 ? 1 : 0;
      outside = now;
      last = sum;
    }
  }
  return slide;
}

TEST(FieldPushes, AreNormalOverAFace) {
  std::mt19937_64 random(1);
  const Quat q = RandomRotation(random);
  const DistanceField field =
      BuiltField(Transformed(Box(kVoxelSize * Vec3(30, 30, 12)), {q, Vec3::Zero()}));
  for (int i = 0; i < 500; ++i) {
    const double gap = Uniform(random, -0.5, 0.44);
    const Vec3 over(Uniform(random, -10, 10), Uniform(random, -10, 10), 6 + gap);
    const Pushes pushes = PushesAt(field, InVoxels(field, kVoxelSize * (q * over)));
    ASSERT_EQ(pushes.size(), 1U);
    EXPECT_NEAR(pushes[0].distance, gap, 0.005);
    EXPECT_GT(pushes[0].away_V.dot(q * Vec3::UnitZ()), 0.9999);
    EXPECT_EQ(pushes[0].share, 1.0);
  }
}

TEST(FieldPushes, BesideAnEdgePointAwayFromIt) {
  std::mt19937_64 random(2);
  const DistanceField field = BuiltField(Box(kVoxelSize * Vec3(30, 30, 30)));
  for (int i = 0; i < 500; ++i) {
    const double angle = Uniform(random, 0, 0.5 * std::numbers::pi);
    const double gap = Uniform(random, 0.05, 0.4);
    const Vec3 way(0, std::cos(angle), std::sin(angle));
    const Vec3 place = Vec3(Uniform(random, -10, 10), 15, 15) + gap * way;
    const Pushes pushes = PushesAt(field, InVoxels(field, kVoxelSize * place));
    ASSERT_EQ(pushes.size(), 1U);
    EXPECT_NEAR(pushes[0].distance, gap, 1e-3);
    EXPECT_GT(pushes[0].away_V.dot(way), 0.9999);
  }
}

// There two faces are as near, at the same place. The face that turns to the place tells.
TEST(FieldPushes, RimHasAFaceTowardsThePosition) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 40; ++i) {
    const Quat q = RandomRotation(random);
    const DistanceField field =
        BuiltField(Transformed(Box(kVoxelSize * Vec3(20, 20, 12)), {q, Vec3::Zero()}));
    for (int k = 0; k < 50; ++k) {
      const double gap = Uniform(random, 0.05, 0.4);
      const double beyond = Uniform(random, 0, 1e-6);
      const Vec3 over(10 + beyond, Uniform(random, -8, 8), 6 + gap);
      const Pushes pushes = PushesAt(field, InVoxels(field, kVoxelSize * (q * over)));
      ASSERT_FALSE(pushes.empty());
      // interpolation may leave a trace of another push
      const FieldPush& push = pushes.back();
      EXPECT_GT(push.share, 0.999);
      EXPECT_GT(push.facing, 0.999);
      EXPECT_GT(push.away_V.dot(q * Vec3::UnitZ()), 0.999);
    }
  }
}

/// Returns the way from the surface's nearest point to a place, unit, by all triangles.
Vec3 WayOff(const TriangleMesh& mesh, const Vec3& p) {
  Vec3 nearest = mesh.corner(0, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 point =
        ClosestOnTriangle(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), p).point;
    if ((point - p).squaredNorm() < (nearest - p).squaredNorm()) nearest = point;
  }
  return (p - nearest).normalized();
}

// Around cells that faces tell, where these give way to interpolation, an interpolated way off may
// be far from any that an edge has.
TEST(FieldPushes, PointAwayFromTheNearestSurfaceWithinTenDegrees) {
  // its corners are nodes of the field, and its sides turn by 39 and 51 degrees
  const std::vector<std::array<double, 2>> polygon{{10.5, -4.5}, {10.5, 4.5},  {6.5, 9.5},
                                                   {-6.5, 9.5},  {-10.5, 4.5}, {-10.5, -4.5},
                                                   {-6.5, -9.5}, {6.5, -9.5}};
  std::mt19937_64 random(8);
  for (int body = 0; body < 30; ++body) {
    // corners as far from a node as chance has it, or nearly upon it
    const double most = body % 2 == 0 ? 0.06 : 0.5;
    const Vec3 aside(Uniform(random, -most, most), Uniform(random, -most, most),
                     Uniform(random, -most, most));
    const TriangleMesh mesh =
        Transformed(testing::Raised(polygon, 13, kVoxelSize),
                    {Quat::Identity(), kVoxelSize * (aside - Vec3(0, 0, 6.5))});
    const DistanceField field = BuiltField(mesh);
    int judged = 0;
    for (int i = 0; i < 4000; ++i) {
      const Vec3 place(Uniform(random, -12, 12), Uniform(random, -12, 12), Uniform(random, 5, 8));
      for (const FieldPush& push : PushesAt(field, InVoxels(field, kVoxelSize * place))) {
        if (push.distance < 0.01 || push.share < 1e-3) continue;
        ++judged;
        EXPECT_GT(push.away_V.dot(WayOff(mesh, kVoxelSize * place)), std::cos(10 / 57.2958))
            << "body " << body << " at " << place.transpose() << ", " << push.distance << " off";
      }
    }
    EXPECT_GT(judged, 100);
  }
}

// Where points are shifted inwards force begins in the solid. A place that is less deep is not
// pushed, least of all farther in.
TEST(FieldPushes, WithAnInwardReachShallowPositionsAreNotPushed) {
  constexpr double kInside = -0.5;  // voxels
  std::mt19937_64 random(9);
  const TriangleMesh mesh = Box(kVoxelSize * Vec3(20.3, 16.7, 12.2));
  const DistanceField field = BuiltField(mesh);
  int pushed = 0;
  for (int i = 0; i < 200'000; ++i) {
    const Vec3 place(Uniform(random, -9.5, -7), Uniform(random, -8, -6), Uniform(random, 4, 5.8));
    const Vec3 place_V = InVoxels(field, kVoxelSize * place);
    FieldPushes pushes;
    field.Pushes({&place_V, 1}, kInside, pushes);
    for (const FieldPush& push : pushes.PushesAt(0)) {
      ++pushed;
      ASSERT_LT(push.distance, kInside) << place.transpose();
      ASSERT_LT(push.away_V.dot(WayOff(mesh, kVoxelSize * place)), 0) << place.transpose();
    }
  }
  EXPECT_GT(pushed, 1000);
}

TEST(FieldPushes, EachFaceOfANotchPushes) {
  const DistanceField field = BuiltField(Notch());
  for (const auto& [from_wall, from_floor] :
       {std::pair(0.2, 0.3), std::pair(0.3, 0.2), std::pair(0.25, 0.25)}) {
    const Vec3 place(-10 + from_wall, 0, 5 + from_floor);
    const Vec3 sum = SumOf(PushesAt(field, InVoxels(field, kVoxelSize * place)));
    EXPECT_NEAR(sum.x(), kReach - from_wall, 0.01);
    EXPECT_NEAR(sum.z(), kReach - from_floor, 0.01);
  }
}

// Two planes at six degrees, as a hollow's facets lie. Each in full would push a place between them
// twice as much as a place beside it.
TEST(FieldPushes, FacesOfAShallowNotchPushAsOne) {
  const double slope = std::tan(3 * M_PI / 180);
  const TriangleMesh notch =
      Raised({{0, 0}, {-20, 20 * slope}, {-20, -10}, {20, -10}, {20, 20 * slope}}, 20, kVoxelSize);
  const DistanceField field = BuiltField(notch);
  for (double aside = -0.1; aside <= 0.1; aside += 0.001) {  // voxels
    const Vec3 place = InVoxels(field, kVoxelSize * Vec3(aside, 0.3, 10));
    const double depth = kReach - field.At(place).value;
    EXPECT_NEAR(SumOf(PushesAt(field, place)).norm(), depth, 0.02 * depth) << aside;
  }
}

/// Returns a block whose upper side falls from the left at `left` degrees to a floor 0.4 voxel wide
/// and rises from there at `right` degrees.
TriangleMesh Valley(double left, double right) {
  const double fall = std::tan(left * M_PI / 180);
  const double rise = std::tan(right * M_PI / 180);
  return Raised({{0, -10},
                 {20, -10},
                 {20, 19.8 * rise},
                 {0.2, 0},
                 {-0.2, 0},
                 {-5.2, 5 * fall},
                 {-20, 5 * fall},
                 {-20, -10}},
                20, kVoxelSize);
}

// Faces less than 45 degrees apart share their weight. Neither which of two faces is nearer may
// change at once how a third one pushes, nor may a face that comes into reach.
TEST(FieldPushes, AreContinuousBetweenFaces) {
  std::mt19937_64 random(9);
  for (const auto& [left, right] : {std::pair(60.0, 20.0), std::pair(40.0, 30.0)}) {
    const DistanceField field = BuiltField(Valley(left, right));
    double largest = 0;
    int pushed = 0;
    for (int line = 0; line < 300; ++line) {
      const Vec3 from(Uniform(random, -0.8, 0.8), Uniform(random, 0.1, 0.8), 10);
      const double angle = Uniform(random, 0, 2 * M_PI);
      const Vec3 way(std::cos(angle), std::sin(angle), 0);
      const Slide slide = SlideAlong(field, from, way, 2e-5, 5120);
      largest = std::max(largest, slide.largest);
      pushed += slide.pushed;
    }
    EXPECT_LT(largest, 0.002) << left << " and " << right;
    EXPECT_GT(pushed, 100'000) << left << " and " << right;
  }
}

TEST(FieldPushes, AreContinuousAlongASlide) {
  std::mt19937_64 random(3);
  for (const TriangleMesh& mesh :
       {Box(kVoxelSize * Vec3(20, 20, 20)), Notch(), Sphere(10 * kVoxelSize, 3)}) {
    const DistanceField field = BuiltField(mesh);
    double largest = 0;
    for (int line = 0; line < 400; ++line) {
      const Vec3 from(Uniform(random, -11, 11), Uniform(random, -11, 11), Uniform(random, 5, 11));
      const Vec3 way = Vec3(Uniform(random, -1, 1), Uniform(random, -1, 1), 0).normalized();
      largest = std::max(largest, SlideAlong(field, from, way, 1e-4, 3008).largest);
    }
    // in a step of 1e-4 voxel a push turns by 1e-4 over its distance at the most, 0.005 of 0.45
    EXPECT_LT(largest, 0.01);
  }
}

TEST(FieldPushes, AreTheSameAloneAndAmongManyAndOnEveryProcessor) {
  std::mt19937_64 random(6);
  // a ball of many small faces: lists of many places do not fit together
  for (const TriangleMesh& mesh : {Notch(), Sphere(10 * kVoxelSize, 4)}) {
    const DistanceField field = BuiltField(mesh);
    std::array<Vec3, FieldPushes::kMostPlaces> places;
    for (Vec3& place : places) {
      const double out = Uniform(random, 9.5, 10.4);
      place = InVoxels(field, kVoxelSize * out * testing::RandomDirection(random));
    }
    places[7] = Vec3::Constant(-3);
    places[9] = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
    std::size_t found = 0;
    for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
      hwy::SetSupportedTargetsForTest(left & -left);
      FieldPushes together;
      field.Pushes(places, kReach, together);
      hwy::SetSupportedTargetsForTest(0);
      for (std::size_t k = 0; k < places.size(); ++k) {
        const Pushes alone = PushesAt(field, places[k]);
        ASSERT_EQ(together.PushesAt(k).size(), alone.size());
        for (std::size_t i = 0; i < alone.size(); ++i, ++found) {
          EXPECT_EQ(together.PushesAt(k)[i].distance, alone[i].distance);
          EXPECT_EQ(together.PushesAt(k)[i].away_V, alone[i].away_V);
          EXPECT_EQ(together.PushesAt(k)[i].share, alone[i].share);
        }
      }
      EXPECT_TRUE(together.PushesAt(7).empty());
      EXPECT_TRUE(together.PushesAt(9).empty());
    }
    EXPECT_GT(found, 30U);
  }
}

}  // namespace
}  // namespace tandem
