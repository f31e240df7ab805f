// Tests bounds of distances against brute force over all triangles.
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

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
using testing::RandomRotation;
using testing::Sphere;
using testing::Uniform;

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
      for (std::size_t lane = 0; lane < kBlockPlaces; ++lane) {
        const Vec3 at = middle + Vec3(lanes[0][lane], lanes[1][lane], lanes[2][lane]);
        const double distance = exact.Signed(kVoxelSize * at) / kVoxelSize;
        const double bound = bounds[lane];
        EXPECT_LE(readings.least, bound);
        if ((readings.listed >> lane & 1U) == 0) ++decided;
        const bool within = (readings.within >> lane & 1U) != 0;
        EXPECT_TRUE(!within || distance < kReach + 0.03) << distance;
        // a place inside is found, however deep
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

// More faces lie in a brick than are asked at once. The told distance stays below the true one.
TEST(FieldBounds, HoldForFacesFarSmallerThanVoxels) {
  const TriangleMesh ball = Sphere(2 * kVoxelSize, 6);
  const DistanceField field = BuiltField(ball);
  ASSERT_GT(field.Count().list_faces, 1024 * field.Count().bricks) << "too few faces in a brick";
  std::mt19937_64 random(5);
  for (int i = 0; i < 13; ++i) {
    std::array<std::array<float, kBlockPlaces>, 3> lanes;
    std::array<double, kBlockPlaces> exact;
    for (std::size_t lane = 0; lane < kBlockPlaces; ++lane) {
      const double radius = Uniform(random, 1.5, 2.5);
      const Vec3 at = radius * testing::RandomDirection(random);
      for (std::size_t a = 0; a < 3; ++a) {
        lanes[a][lane] = static_cast<float>(at[static_cast<Eigen::Index>(a)]);
      }
      exact[lane] = radius - 2;
    }
    const Vec3 middle = InVoxels(field, Vec3::Zero());
    const GridIndex base{static_cast<std::int32_t>(middle.x()),
                         static_cast<std::int32_t>(middle.y()),
                         static_cast<std::int32_t>(middle.z())};
    const PlacedBlock placed{.places_F = {lanes[0].data(), lanes[1].data(), lanes[2].data()},
                             .base = base,
                             .from_base = {static_cast<float>(middle.x() - base.x),
                                           static_cast<float>(middle.y() - base.y),
                                           static_cast<float>(middle.z() - base.z)}};
    std::array<float, kBlockPlaces> bounds;
    FieldReadings readings;
    field.ReadBlocks({1, 0, 0, 0, 1, 0, 0, 0, 1}, static_cast<float>(kReach), {&placed, 1},
                     bounds.data(), &readings);
    for (std::size_t lane = 0; lane < kBlockPlaces; ++lane) {
      EXPECT_LE(bounds[lane], exact[lane] + 0.01);
    }
  }
}

}  // namespace
}  // namespace tandem
