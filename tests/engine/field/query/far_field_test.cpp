// Tests how far surfaces are said to be beyond the band, out to a long range, against brute force
// over all triangles.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "engine/field/build/field_builder.h"
#include "engine/geometry/import/mesh_file.h"
#include "tests/engine/field/brute_distance.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::At;
using testing::Box;
using testing::BruteDistance;
using testing::HollowBlock;
using testing::RandomRotation;
using testing::Sphere;
using testing::Uniform;

constexpr double kFarVoxel = 0.001;
constexpr double kFar = 10;         // voxels of range
constexpr double kRounding = 4e-3;  // voxels; rounding of what is stored

DistanceField FarFieldOf(const TriangleMesh& mesh, double range) {
  return std::move(*BuildField(mesh, {.voxel_size = kFarVoxel, .range = range}));
}

/// Returns how near the pushes say that the surface is; nothing if none pushes.
std::optional<double> NearestPush(const DistanceField& field, const Vec3& place_V, double reach) {
  FieldPushes pushes;
  field.Pushes({&place_V, 1}, reach, pushes);
  std::optional<double> nearest;
  for (const FieldPush& push : pushes.PushesAt(0)) {
    nearest = std::min(nearest.value_or(reach), push.distance);
  }
  return nearest;
}

struct PushErrors {
  double late = 0;  // voxels
  double early = 0;
};

/// Returns the errors of pushes at places of the free side, from the band out to the range.
PushErrors PushErrorsOf(const TriangleMesh& mesh, double voxel_size, const DistanceField& field,
                        int count) {
  std::mt19937_64 random(5);
  const BruteDistance exact(mesh);
  PushErrors errors;
  for (int i = 0; i < count; ++i) {
    const Vec3 p_W = exact.PlaceNear(field.range() * voxel_size, random);
    const double distance = exact.Signed(p_W) / voxel_size;
    if (distance < field.band() || distance >= field.range()) continue;
    const Vec3 place_V = (p_W - field.p_WVo()) / voxel_size;
    const std::optional<double> reported = NearestPush(field, place_V, field.range() + kRounding);
    if (!reported) {
      ADD_FAILURE() << "nothing pushes " << distance << " voxels off";
      continue;
    }
    errors.late = std::max(errors.late, *reported - distance);
    errors.early = std::max(errors.early, distance - *reported);
  }
  return errors;
}

/// Returns boxes with nothing in common, turned and strewn: many sharp edges and narrow gaps.
TriangleMesh StrewnBoxes(std::mt19937_64& random) {
  TriangleMesh mesh;
  for (int i = 0; i < 27; ++i) {
    const Vec3 size(Uniform(random, 1, 6), Uniform(random, 1, 6), Uniform(random, 1, 6));
    const Vec3 middle = 12 * Vec3(i % 3, i / 3 % 3, i / 9);
    Append(mesh, At(Box(kFarVoxel * size), kFarVoxel * middle, RandomRotation(random)));
  }
  return mesh;
}

TEST(FarField, IsNeverLateAndAtMostHalfAVoxelEarlyBesideConvexBodies) {
  std::mt19937_64 random(3);
  for (const TriangleMesh& mesh :
       {Box(kFarVoxel * Vec3(11, 7.3, 9)), Sphere(12 * kFarVoxel, 4), Sphere(9 * kFarVoxel, 1),
        Box(kFarVoxel * Vec3(30, 20, 0.3)), Box(kFarVoxel * Vec3(20, 1, 1))}) {
    const TriangleMesh turned = At(mesh, Vec3(0.003, -0.02, 0.01), RandomRotation(random));
    for (const double range : {DistanceField::kLeastRange, kFar}) {
      const PushErrors errors = PushErrorsOf(turned, kFarVoxel, FarFieldOf(turned, range), 6000);
      EXPECT_LT(errors.late, kRounding);
      EXPECT_LT(errors.early, 0.5);
    }
  }
}

// Half way between two surfaces interpolation is half a voxel low besides.
TEST(FarField, IsNeverLateBetweenSurfaces) {
  std::mt19937_64 random(4);
  for (const TriangleMesh& mesh :
       {StrewnBoxes(random), StrewnBoxes(random), HollowBlock(40 * kFarVoxel, 15 * kFarVoxel)}) {
    const PushErrors errors = PushErrorsOf(mesh, kFarVoxel, FarFieldOf(mesh, kFar), 6000);
    EXPECT_LT(errors.late, kRounding);
    EXPECT_LT(errors.early, 0.95);
  }
}

// A schedule looks for points by vectors, and pushes by Pushes(): no push is left out.
TEST(FarField, BlocksContainEveryPushedPosition) {
  std::mt19937_64 random(6);
  const TriangleMesh mesh = StrewnBoxes(random);
  const DistanceField field = FarFieldOf(mesh, kFar);
  int pushed = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 middle = (kFarVoxel * Vec3(Uniform(random, -12, 36), Uniform(random, -12, 36),
                                          Uniform(random, -12, 36)) -
                         field.p_WVo()) /
                        kFarVoxel;
    const double reach = Uniform(random, 0.2, kFar);
    std::array<float, kBlockPlaces> x, y, z;
    for (std::size_t k = 0; k < kBlockPlaces; ++k) {
      x[k] = static_cast<float>(Uniform(random, -3, 3));
      y[k] = static_cast<float>(Uniform(random, -3, 3));
      z[k] = static_cast<float>(Uniform(random, -3, 3));
    }
    const GridIndex base{static_cast<std::int32_t>(middle.x()),
                         static_cast<std::int32_t>(middle.y()),
                         static_cast<std::int32_t>(middle.z())};
    const PlacedBlock block{.places_F = {x.data(), y.data(), z.data()}, .base = base};
    std::array<float, kBlockPlaces> bounds;
    FieldReadings readings;
    field.ReadBlocks({1, 0, 0, 0, 1, 0, 0, 0, 1}, static_cast<float>(reach), {&block, 1},
                     bounds.data(), &readings);
    for (std::size_t k = 0; k < kBlockPlaces; ++k) {
      const Vec3 place = Vec3(base.x, base.y, base.z) + Vec3(x[k], y[k], z[k]);
      const std::optional<double> reported = NearestPush(field, place, reach - kRounding);
      if (!reported) continue;
      ++pushed;
      const bool found = (readings.within >> k & 1U) != 0;
      ASSERT_TRUE(found) << *reported << " of " << reach;
    }
  }
  EXPECT_GT(pushed, 5000);
}

TEST(FarField, PushesAreContinuous) {
  std::mt19937_64 random(8);
  const TriangleMesh mesh =
      At(Box(kFarVoxel * Vec3(9, 6, 12)), Vec3::Zero(), RandomRotation(random));
  const DistanceField field = FarFieldOf(mesh, kFar);
  constexpr double kStep = 0.002;  // voxels
  for (int line = 0; line < 40; ++line) {
    const auto sum_at = [&](const Vec3& place_V) {
      FieldPushes pushes;
      field.Pushes({&place_V, 1}, kFar, pushes);
      Vec3 sum = Vec3::Zero();
      for (const FieldPush& push : pushes.PushesAt(0)) {
        sum += (kFar - push.distance) * push.share * push.away_V;
      }
      return sum;
    };
    const Vec3 way = testing::RandomDirection(random);
    const Vec3 from = -field.p_WVo() / kFarVoxel + testing::RandomDirection(random) * 9.0;
    Vec3 before = sum_at(from);
    for (int i = 1; i < 4000; ++i) {
      const Vec3 p = from + i * kStep * way;
      // the solid has no way out for what is deep
      if (field.At(p).value < 0.1) break;
      const Vec3 now = sum_at(p);
      // a depth of ten voxels turns by the step over the distance at the most
      ASSERT_LT((now - before).norm(), 0.12) << line << ", " << i;
      before = now;
    }
  }
}

TEST(FarField, IsTheSameForAnyNumberOfThreads) {
  std::mt19937_64 random(9);
  const TriangleMesh mesh = StrewnBoxes(random);
  const std::uint64_t by_all = FarFieldOf(mesh, 6).Digest();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(FarFieldOf(mesh, 6).Digest(), by_all);
}

TEST(FarField, IsNeverLateBesideMeshesThatOthersMade) {
  const char* folder =
      std::getenv("TANDEM_MODELS");  // NOLINT(concurrency-mt-unsafe): nobody sets it
  if (folder == nullptr) GTEST_SKIP() << "TANDEM_MODELS does not name the folder of the models";
  for (const char* name :
       {"factory/factory_bolt_m16_loose.obj", "so101/Wrist_Roll_SO101.stl",
        "classic/spot_triangulated.obj", "factory/factory_rectangular_hole_8mm_subdiv_3x.obj"}) {
    const Result<TriangleMesh> mesh =
        ImportMesh(std::filesystem::path(folder) / name, {.seconds_limit = 60});
    ASSERT_TRUE(mesh) << mesh.error().what;
    const double voxel_size = BoundsOf(*mesh).size().maxCoeff() / 100;
    const Result<DistanceField> field = BuildField(*mesh, {.voxel_size = voxel_size, .range = 6});
    ASSERT_TRUE(field) << name << ": " << field.error().what;
    const PushErrors errors = PushErrorsOf(*mesh, voxel_size, *field, 1000);
    EXPECT_LT(errors.late, kRounding) << name;
    EXPECT_LT(errors.early, 0.95) << name;
  }
}

}  // namespace
}  // namespace tandem
