// Pushes off surfaces whose ways are known in closed form, and bounds against brute force over all
// triangles.
#include <algorithm>
#include <array>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/field/field_builder.h"
#include "tests/engine/field/brute_distance.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Box;
using testing::BruteDistance;
using testing::HollowBlock;
using testing::RandomRotation;
using testing::Sphere;
using testing::Uniform;

constexpr double kVoxelSize = 0.001;
constexpr double kReach = 0.45;  // voxels

using Pushes = std::array<FieldPush, DistanceField::kMostPushes>;

DistanceField BuiltField(const TriangleMesh& mesh) {
  return std::move(*BuildField(mesh, {.voxel_size = kVoxelSize}));
}

Vec3 InVoxels(const DistanceField& field, const Vec3& p_W) {
  return (p_W - field.p_WVo()) / kVoxelSize;
}

/// What the pushes come to, in voxels of depth.
Vec3 SumOf(const Pushes& pushes, std::size_t count) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    sum += (kReach - pushes[i].distance) * pushes[i].share * pushes[i].away_V;
  }
  return sum;
}

/// A floor and a wall that stand on one another at a right angle.
TriangleMesh Notch() {
  TriangleMesh notch = Box(kVoxelSize * Vec3(40, 40, 10));
  Append(notch, Transformed(Box(kVoxelSize * Vec3(10, 40, 30)),
                            {Quat::Identity(), kVoxelSize * Vec3(-15, 0, 10)}));
  return notch;
}

TEST(FieldPushes, OverAFaceTheyStandOnIt) {
  std::mt19937_64 random(1);
  const Quat q = RandomRotation(random);
  const DistanceField field =
      BuiltField(Transformed(Box(kVoxelSize * Vec3(30, 30, 12)), {q, Vec3::Zero()}));
  for (int i = 0; i < 500; ++i) {
    const double gap = Uniform(random, -0.5, 0.44);
    const Vec3 over(Uniform(random, -10, 10), Uniform(random, -10, 10), 6 + gap);
    Pushes pushes;
    const std::size_t count =
        field.Pushes(InVoxels(field, kVoxelSize * (q * over)), kReach, pushes);
    ASSERT_EQ(count, 1U);
    EXPECT_NEAR(pushes[0].distance, gap, 0.005);
    EXPECT_GT(pushes[0].away_V.dot(q * Vec3::UnitZ()), 0.9999);
    EXPECT_EQ(pushes[0].share, 1.0);
  }
}

TEST(FieldPushes, BesideAnEdgeTheyComeFromTheEdge) {
  std::mt19937_64 random(2);
  const DistanceField field = BuiltField(Box(kVoxelSize * Vec3(30, 30, 30)));
  for (int i = 0; i < 500; ++i) {
    const double angle = Uniform(random, 0, 0.5 * std::numbers::pi);
    const double gap = Uniform(random, 0.05, 0.4);
    const Vec3 way(0, std::cos(angle), std::sin(angle));
    const Vec3 place = Vec3(Uniform(random, -10, 10), 15, 15) + gap * way;
    Pushes pushes;
    const std::size_t count = field.Pushes(InVoxels(field, kVoxelSize * place), kReach, pushes);
    ASSERT_EQ(count, 1U);
    EXPECT_NEAR(pushes[0].distance, gap, 1e-3);
    EXPECT_GT(pushes[0].away_V.dot(way), 0.9999);
  }
}

TEST(FieldPushes, InANotchEachFacePushes) {
  const DistanceField field = BuiltField(Notch());
  for (const auto& [from_wall, from_floor] :
       {std::pair(0.2, 0.3), std::pair(0.3, 0.2), std::pair(0.25, 0.25)}) {
    Pushes pushes;
    const Vec3 place(-10 + from_wall, 0, 5 + from_floor);
    const std::size_t count = field.Pushes(InVoxels(field, kVoxelSize * place), kReach, pushes);
    const Vec3 sum = SumOf(pushes, count);
    EXPECT_NEAR(sum.x(), kReach - from_wall, 0.01);
    EXPECT_NEAR(sum.z(), kReach - from_floor, 0.01);
  }
}

TEST(FieldPushes, DoNotJumpAsAPlaceSlides) {
  std::mt19937_64 random(3);
  for (const TriangleMesh& mesh :
       {Box(kVoxelSize * Vec3(20, 20, 20)), Notch(), Sphere(10 * kVoxelSize, 3)}) {
    const DistanceField field = BuiltField(mesh);
    double largest = 0;
    for (int line = 0; line < 400; ++line) {
      const Vec3 from(Uniform(random, -11, 11), Uniform(random, -11, 11), Uniform(random, 5, 11));
      const Vec3 way = Vec3(Uniform(random, -1, 1), Uniform(random, -1, 1), 0).normalized();
      constexpr double kStep = 1e-4;
      constexpr int kSteps = 3000;
      Vec3 last = Vec3::Zero();
      bool outside = false;
      for (int i = 0; i < kSteps; ++i) {
        const Vec3 place = InVoxels(field, kVoxelSize * (from + i * kStep * way));
        Pushes pushes;
        const std::size_t count = field.Pushes(place, kReach, pushes);
        const Vec3 sum = SumOf(pushes, count);
        const bool now = field.At(place).value > 0.02;
        if (outside && now) largest = std::max(largest, (sum - last).norm());
        outside = now;
        last = sum;
      }
    }
    // in a step of 1e-4 voxel a push turns by 1e-4 over its distance at the most, 0.005 of 0.45
    EXPECT_LT(largest, 0.01);
  }
}

TEST(FieldBounds, AreNeverAboveTheDistance) {
  std::mt19937_64 random(4);
  const std::vector<TriangleMesh> meshes{
      Box(kVoxelSize * Vec3(20, 14, 9)), Box(kVoxelSize * Vec3(20, 14, 0.7)),
      Sphere(9 * kVoxelSize, 2), HollowBlock(20 * kVoxelSize, 6 * kVoxelSize), Notch()};
  for (const TriangleMesh& mesh_B : meshes) {
    const Quat q = RandomRotation(random);
    const TriangleMesh mesh = Transformed(mesh_B, {q, Vec3::Zero()});
    const DistanceField field = BuiltField(mesh);
    const BruteDistance exact(mesh);
    std::size_t decided = 0;
    for (int block = 0; block < 300; ++block) {
      std::array<std::array<float, kBlockPlaces>, 3> lanes;
      const Vec3 middle(Uniform(random, -16, 16), Uniform(random, -16, 16),
                        Uniform(random, -16, 16));
      for (auto& axis : lanes) {
        for (float& value : axis) value = static_cast<float>(Uniform(random, -3, 3));
      }
      const Vec3 place = InVoxels(field, kVoxelSize * middle);
      const Vec3 base = place.array().floor();
      PlacedBlock placed;
      placed.places_F = {lanes[0].data(), lanes[1].data(), lanes[2].data()};
      placed.base = {static_cast<std::int32_t>(base.x()), static_cast<std::int32_t>(base.y()),
                     static_cast<std::int32_t>(base.z())};
      for (std::size_t a = 0; a < 3; ++a) {
        const auto axis = static_cast<Eigen::Index>(a);
        placed.from_base[a] = static_cast<float>(place[axis] - base[axis]);
      }
      std::array<float, kBlockPlaces> bounds;
      FieldReadings readings;
      field.ReadBlocks({1, 0, 0, 0, 1, 0, 0, 0, 1}, static_cast<float>(kReach), {&placed, 1},
                       bounds.data(), &readings);
      std::vector<DistanceField::OpenPlace> open;
      for (std::size_t lane = 0; lane < kBlockPlaces; ++lane) {
        if ((readings.open >> lane & 1U) == 0) continue;
        const Vec3 at = middle + Vec3(lanes[0][lane], lanes[1][lane], lanes[2][lane]);
        open.push_back({InVoxels(field, kVoxelSize * at), bounds[lane]});
      }
      std::vector<double> told(open.size());
      field.Distances(open, kReach, told.data());
      std::size_t next = 0;
      for (std::size_t lane = 0; lane < kBlockPlaces; ++lane) {
        const Vec3 at = middle + Vec3(lanes[0][lane], lanes[1][lane], lanes[2][lane]);
        const double distance = exact.Signed(kVoxelSize * at) / kVoxelSize;
        double bound = bounds[lane];
        if ((readings.open >> lane & 1U) != 0) {
          bound = told[next++];
        } else {
          ++decided;
          const bool within = (readings.within >> lane & 1U) != 0;
          EXPECT_TRUE(!within || distance < kReach + 0.03) << distance;
        }
        // what lies inside is found, however deep
        if (distance > 0) {
          EXPECT_LE(bound, distance + 0.012) << at.transpose();
        }
        if (distance < -0.05) {
          EXPECT_LT(bound, kReach) << at.transpose();
        }
      }
    }
    EXPECT_GT(decided, 1000U);
  }
}

// More faces lie in a brick than are asked at once: what is told stays below the distance.
TEST(FieldBounds, HoldWhereFacesAreFarSmallerThanVoxels) {
  const TriangleMesh ball = Sphere(2 * kVoxelSize, 6);
  const DistanceField field = BuiltField(ball);
  ASSERT_GT(field.Count().list_faces, 1024 * field.Count().bricks) << "too few faces in a brick";
  std::mt19937_64 random(5);
  std::vector<DistanceField::OpenPlace> open;
  std::vector<double> exact;
  for (int i = 0; i < 200; ++i) {
    const double radius = Uniform(random, 1.5, 2.5);
    const Vec3 at = radius * kVoxelSize * testing::RandomDirection(random);
    open.push_back({InVoxels(field, at), -1});
    exact.push_back(radius - 2);
  }
  std::vector<double> told(open.size());
  field.Distances(open, kReach, told.data());
  for (std::size_t i = 0; i < told.size(); ++i) EXPECT_LE(told[i], exact[i] + 0.01) << i;
}

}  // namespace
}  // namespace tandem
