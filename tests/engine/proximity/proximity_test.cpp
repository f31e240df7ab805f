#include "engine/proximity/proximity.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "engine/voxel/build/voxelize.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::AllocationCounter;
using testing::At;
using testing::Box;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Sheet;
using testing::Sphere;
using testing::Uniform;

constexpr double kProximityVoxel = 0.001;
const double kBound = std::sqrt(3.0) * kProximityVoxel;  // voxels against voxels of the same size
constexpr double kPi = 3.14159265358979323846;
const Vec3 kOff(0.00031, -0.00017, 0.00023);  // so that nothing lies on the grid's planes

ProximityShape ShapeOf(const TriangleMesh& mesh_W, double voxel = kProximityVoxel) {
  Result<Voxmap> map = Voxelize(mesh_W, {.voxel_size = voxel});
  EXPECT_TRUE(map.has_value());
  return {mesh_W, std::move(*map)};
}

/// Returns the exact way from a box of half sides `half` about the origin to p, which is outside.
Vec3 FromBox(const Vec3& half, const Vec3& p) {
  return p - p.cwiseMin(half).cwiseMax(-half);
}

double Degrees(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / kPi;
}

/// Errors of a direction, degrees.
struct Errors {
  double sum = 0;
  double most = 0;
  int count = 0;
  void Add(double error) {
    sum += error;
    most = std::max(most, error);
    ++count;
  }
  double mean() const { return sum / std::max(1, count); }
};

/// Voxels off the surface, and the angles stated for it.
struct Stated {
  double from, to;
  double mean, most;
};

void ExpectWithin(const char* shape, const Stated& stated, const Errors& errors) {
  const std::string key = shape + ("_from_" + std::to_string(static_cast<int>(stated.from)));
  ::testing::Test::RecordProperty(key + "_mean_deg", std::to_string(errors.mean()));
  ::testing::Test::RecordProperty(key + "_most_deg", std::to_string(errors.most));
  EXPECT_GE(errors.count, 500);
  EXPECT_LE(errors.mean(), stated.mean);
  EXPECT_LE(errors.most, stated.most);
}

TEST(VoxelGradient, IsWithinItsStatedAngleOnASphere) {
  const double radius = 0.025;
  const ProximityShape sphere = ShapeOf(At(Sphere(radius, 5), kOff));
  std::mt19937_64 random(3);
  for (const Stated& stated :
       {Stated{0, 1, 3.5, 15}, {1, 2, 4, 15}, {2, 4, 2.5, 10}, {4, 8, 1.5, 7}}) {
    Errors errors;
    for (int i = 0; i < 1000; ++i) {
      const Vec3 n = RandomDirection(random);
      const Vec3 p =
          kOff + (radius + kProximityVoxel * Uniform(random, stated.from, stated.to)) * n;
      errors.Add(Degrees(VoxelGradient(sphere, p), n));
    }
    ExpectWithin("sphere by voxels", stated, errors);
  }
}

// The worst of it is beside the edges, where voxels of two faces and of the edge have their say.
TEST(VoxelGradient, IsWithinItsStatedAngleOnARotatedBox) {
  const Vec3 half(0.02, 0.015, 0.01);
  std::mt19937_64 random(4);
  for (const Stated& stated :
       {Stated{0, 1, 7.5, 50}, {1, 2, 6, 40}, {2, 4, 5, 25}, {4, 8, 4.5, 25}}) {
    Errors errors;
    for (int turn = 0; turn < 5; ++turn) {
      const Quat q = RandomRotation(random);
      const ProximityShape box = ShapeOf(At(Box(2 * half), kOff, q));
      for (int i = 0; i < 4000; ++i) {
        const Vec3 p(Uniform(random, -0.03, 0.03), Uniform(random, -0.025, 0.025),
                     Uniform(random, -0.02, 0.02));
        const Vec3 away = FromBox(half, p);
        const double voxels = away.norm() / kProximityVoxel;
        if (voxels == 0 || voxels < stated.from || voxels >= stated.to) continue;
        errors.Add(Degrees(VoxelGradient(box, q * p + kOff), q * away));
      }
    }
    ExpectWithin("box by voxels", stated, errors);
  }
}

TEST(VoxelGradient, PointsOutwardsInsideABody) {
  const ProximityShape box = ShapeOf(At(Box(Vec3(0.04, 0.03, 0.02)), kOff));
  for (const double depth : {0.2, 0.6, 1.1, 3.0, 6.0}) {
    const Vec3 p = kOff + Vec3(0.002, 0.001, 0.01 - depth * kProximityVoxel);
    EXPECT_LT(Degrees(VoxelGradient(box, p), Vec3::UnitZ()), 15) << depth;
  }
}

TEST(VoxelGradient, IsZeroBeyondTheRange) {
  const ProximityShape box = ShapeOf(At(Box(Vec3(0.04, 0.03, 0.02)), kOff));
  EXPECT_EQ(VoxelGradient(box, kOff + Vec3(0, 0, 0.03)), Vec3(Vec3::Zero()));
}

// Sphere against turned box: the exact distance is that of the centre less the radius, which the
// sphere's triangles miss by less than 0.001 radii.
TEST(ProximityPair, StatedErrorHoldsForSphereAndBox) {
  const double radius = 0.02;
  const double facets = 1e-3 * radius;
  const Vec3 half(0.03, 0.02, 0.012);
  std::mt19937_64 random(6);
  const Quat q_box = RandomRotation(random);
  const ProximityShape sphere = ShapeOf(At(Sphere(radius, 5), kOff));
  const ProximityShape box = ShapeOf(At(Box(2 * half), kOff, q_box));
  ProximityPair pair(sphere, box);
  double worst_voxels = 0;
  double worst_refined = 0;
  for (int i = 0; i < 300; ++i) {
    // the sphere's centre in the box's own axes
    const double farther = i % 3 == 0 ? 0.3 : 0.035;
    const Vec3 c =
        Vec3(Uniform(random, -1, 1), Uniform(random, -1, 1), Uniform(random, -1, 1)) * farther;
    const Vec3 away = FromBox(half, c);
    const double exact = away.norm() - radius;
    if (exact < 0.05 * kProximityVoxel) continue;
    const Quat turn = RandomRotation(random);
    const Pose X_BA{turn, q_box * c + kOff - turn * kOff};
    const Nearness coarse = pair.Nearest(X_BA, {.refine = false});
    EXPECT_FALSE(coarse.refined);
    EXPECT_LE(coarse.error_bound(), 1.001 * kBound);
    EXPECT_LE(coarse.least, exact + facets);
    EXPECT_GE(coarse.most, exact);
    EXPECT_NEAR((coarse.p_BA - coarse.p_BB).norm(), coarse.distance, 1e-6);
    EXPECT_NEAR(coarse.gradient_B.norm(), 1, 1e-9);
    EXPECT_LT(Degrees(coarse.gradient_B, q_box * away), 50);
    worst_voxels = std::max(worst_voxels, std::abs(coarse.distance - exact));

    const Nearness fine = pair.Nearest(X_BA);
    EXPECT_TRUE(fine.refined);
    EXPECT_FALSE(fine.overlap);
    EXPECT_LE(fine.least, exact + facets);
    EXPECT_GE(fine.most, exact - 1e-9);
    EXPECT_LE(fine.error_bound(), 2e-3 * kProximityVoxel) << i;
    EXPECT_NEAR((fine.p_BA - fine.p_BB).norm(), fine.distance, 1e-9);
    // the two points: the sphere's nearest and the box's, as the oracle has them
    const Vec3 direction = q_box * away.normalized();
    EXPECT_LT((fine.p_BB - (kOff + q_box * (c - away))).norm(), 0.05 * radius);
    EXPECT_LT(Degrees(fine.gradient_B, direction), 3);
    worst_refined = std::max(worst_refined, std::abs(fine.distance - exact));
  }
  RecordProperty("worst_voxels", std::to_string(worst_voxels / kProximityVoxel));
  RecordProperty("worst_refined_voxels", std::to_string(worst_refined / kProximityVoxel));
  EXPECT_LE(worst_voxels, kBound);
  EXPECT_LE(worst_refined, facets);
}

TEST(ProximityPair, AppliesBothDisplacements) {
  const ProximityShape left = ShapeOf(At(Box(Vec3(0.02, 0.02, 0.02)), Vec3(-0.05, 0, 0) + kOff));
  const ProximityShape right = ShapeOf(At(Box(Vec3(0.02, 0.02, 0.02)), Vec3(0.05, 0, 0) + kOff));
  ProximityPair pair(left, right);
  EXPECT_NEAR(pair.Nearest(Pose{}).distance, 0.08, 1e-9);
  // both turned by the same quarter about z: the same distance
  const Pose quarter{Quat(Eigen::AngleAxisd(0.5 * kPi, Vec3::UnitZ())), Vec3(0.3, 0.2, 0.1)};
  EXPECT_NEAR(pair.Nearest(quarter.Inverse() * quarter).distance, 0.08, 1e-9);
  const Pose nearer{Quat::Identity(), Vec3(0.07, 0, 0)};
  const Nearness near = pair.Nearest(quarter.Inverse() * (quarter * nearer));
  EXPECT_NEAR(near.distance, 0.01, 1e-9);
  EXPECT_LT((near.gradient_B + Vec3::UnitX()).norm(), 1e-6);
}

TEST(ProximityPair, OverlappingAndContainedBodiesHaveZeroDistance) {
  const ProximityShape big = ShapeOf(At(Box(Vec3(0.06, 0.06, 0.06)), kOff));
  const ProximityShape small = ShapeOf(At(Box(Vec3(0.01, 0.01, 0.01)), kOff));
  ProximityPair pair(small, big);
  for (const double x : {0.0, 0.02, 0.03}) {  // deep within, near the wall, across it
    for (const bool refine : {false, true}) {
      const Nearness near = pair.Nearest({Quat::Identity(), Vec3(x, 0, 0)}, {.refine = refine});
      EXPECT_TRUE(near.overlap) << x;
      EXPECT_EQ(near.distance, 0) << x;
      EXPECT_LE(near.most, kBound / 2 + 1e-9) << x;
    }
  }
  EXPECT_FALSE(pair.Nearest({Quat::Identity(), Vec3(0.036, 0, 0)}).overlap);
  EXPECT_NEAR(pair.Nearest({Quat::Identity(), Vec3(0.036, 0, 0)}).distance, 0.001, 1e-9);
}

// Voxels of the one reach into the other there, and say nothing of the surfaces.
TEST(ProximityPair, BodiesAFractionOfAVoxelApartDoNotOverlap) {
  std::mt19937_64 random(8);
  const TriangleMesh box = Box(Vec3(0.02, 0.02, 0.02));
  for (int i = 0; i < 60; ++i) {
    const Quat q = RandomRotation(random);
    const ProximityShape below = ShapeOf(At(box, kOff, q));
    const ProximityShape above = ShapeOf(At(box, kOff, q));
    ProximityPair pair(above, below);
    const double gap = Uniform(random, 0.02, 0.5) * kProximityVoxel;
    const Vec3 aside(Uniform(random, -0.01, 0.01), Uniform(random, -0.01, 0.01), 0.02);
    const Nearness apart = pair.Nearest({Quat::Identity(), q * (aside + gap * Vec3::UnitZ())});
    EXPECT_FALSE(apart.overlap) << i;
    EXPECT_NEAR(apart.distance, gap, 2e-3 * kProximityVoxel) << i;
    const Nearness crossing = pair.Nearest({Quat::Identity(), q * (aside - gap * Vec3::UnitZ())});
    EXPECT_TRUE(crossing.overlap) << i;
    EXPECT_EQ(crossing.most, 0) << i;
  }
}

// The ball is as near to the wall from within. Surfaces that do not cross are no sign that the
// bodies are apart.
TEST(ProximityPair, BodyJustInsideAWallOverlaps) {
  std::mt19937_64 random(9);
  for (int i = 0; i < 20; ++i) {
    const Quat q = RandomRotation(random);
    const ProximityShape big = ShapeOf(At(Box(Vec3(0.06, 0.06, 0.06)), kOff, q));
    const ProximityShape small = ShapeOf(At(Box(Vec3(0.01, 0.01, 0.01)), kOff, q));
    ProximityPair pair(small, big);
    const double in_wall = 0.025 - Uniform(random, 0.05, 0.5) * kProximityVoxel;
    const Nearness near = pair.Nearest({Quat::Identity(), q * Vec3(in_wall, 0, 0)});
    EXPECT_TRUE(near.overlap) << i;
    EXPECT_EQ(near.distance, 0) << i;
  }
}

TEST(ProximityPair, EmptyBodyIsInfinitelyFar) {
  const ProximityShape box = ShapeOf(Box(Vec3(0.01, 0.01, 0.01)));
  const ProximityShape none;
  EXPECT_EQ(ProximityPair(box, none).Nearest(Pose{}).distance,
            std::numeric_limits<double>::infinity());
  EXPECT_EQ(ProximityPair(none, box).Shadow(Pose{}, 1, {}).found, 0U);
}

// Parallel sheets of many triangles leave everything in question: the search ends all the same, and
// what it states still holds.
TEST(ProximityPair, StatedErrorHoldsForATruncatedSearch) {
  const ProximityShape outer = ShapeOf(At(Sphere(0.03, 5), kOff));
  const ProximityShape inner = ShapeOf(At(Sphere(0.025, 5), kOff));
  ProximityPair pair(outer, inner);  // the outer sphere's points are not inside the inner one
  for (const std::size_t most : {std::size_t{1}, std::size_t{1000}, std::size_t{20000}}) {
    const Nearness near = pair.Nearest(Pose{}, {.most_pairs = most});
    EXPECT_LE(near.least, 0.005 + 1e-3 * 0.03);
    EXPECT_GE(near.most, 0.005 - 1e-3 * 0.03);
    EXPECT_LE(near.error_bound(), 1.001 * kBound);
  }
}

TEST(Shadow, IsEverySurfaceVoxelWithinTheDistanceAndNoOther) {
  const ProximityShape plate = ShapeOf(At(Box(Vec3(0.1, 0.08, 0.01)), kOff));
  std::mt19937_64 random(8);
  const ProximityShape body = ShapeOf(At(Box(Vec3(0.02, 0.015, 0.012)), kOff));
  ProximityPair pair(body, plate);
  std::vector<Vec3> voxels_A;
  body.surface.VisitWithin(Vec3::Zero(), 1, [&](const Vec3& c) {
    voxels_A.push_back(c);
  });
  std::vector<Vec3> voxels_B;
  plate.surface.VisitWithin(Vec3::Zero(), 1, [&](const Vec3& c) {
    voxels_B.push_back(c);
  });
  ASSERT_EQ(voxels_A.size(), body.surface.voxel_count());
  std::vector<Vec3> shadow(plate.surface.voxel_count());
  for (int i = 0; i < 3; ++i) {
    const Pose X_BA{RandomRotation(random), Vec3(Uniform(random, -0.05, 0.05), 0.01, 0.018)};
    const double distance = kProximityVoxel * Uniform(random, 3, 7);
    const ShadowCount count = pair.Shadow(X_BA, distance, shadow);
    EXPECT_FALSE(count.capped());
    std::size_t expected = 0;
    std::size_t doubtful = 0;  // to the rounding of single precision
    for (const Vec3& b : voxels_B) {
      double least = 1e9;
      for (const Vec3& a : voxels_A) least = std::min(least, (X_BA * a - b).norm());
      expected += least <= distance ? 1 : 0;
      doubtful += std::abs(least - distance) < 1e-4 * kProximityVoxel ? 1 : 0;
      if (std::abs(least - distance) < 1e-4 * kProximityVoxel) continue;
      const bool found =
          std::find(shadow.begin(), shadow.begin() + static_cast<long>(count.written), b) !=
          shadow.begin() + static_cast<long>(count.written);
      EXPECT_EQ(found, least <= distance);
    }
    EXPECT_GT(expected, 50U);
    EXPECT_NEAR(static_cast<double>(count.found), static_cast<double>(expected),
                static_cast<double>(doubtful));
    // less room: as many as go in, and the whole number
    const ShadowCount capped = pair.Shadow(X_BA, distance, std::span(shadow).first(20));
    EXPECT_EQ(capped.found, count.found);
    EXPECT_EQ(capped.written, 20U);
    EXPECT_TRUE(capped.capped());
  }
}

TEST(LowerDistances, AreWithinTheStatedErrorOfExactDistances) {
  const Vec3 half(0.02, 0.015, 0.01);
  std::mt19937_64 random(9);
  const Quat q = RandomRotation(random);
  const ProximityShape box = ShapeOf(At(Box(2 * half), kOff, q));
  std::vector<std::array<float, 3>> points;
  std::vector<double> exact;
  const Pose X_BA{RandomRotation(random), Vec3(0.4, -0.2, 0.3)};
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p(Uniform(random, -0.04, 0.04), Uniform(random, -0.035, 0.035),
                 Uniform(random, -0.03, 0.03));
    const Eigen::Vector3f p_A = (X_BA.Inverse() * (q * p + kOff)).cast<float>();
    points.push_back({p_A.x(), p_A.y(), p_A.z()});
    exact.push_back(FromBox(half, p).norm());
  }
  std::vector<float> distances(points.size(), 1.0F);
  LowerDistances(points, X_BA, box.voxmap, distances);
  int beyond = 0;
  int inside = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double read = distances[i];
    if (read == 1.0) {
      ++beyond;
      EXPECT_GT(exact[i], 7 * kProximityVoxel);
      continue;
    }
    EXPECT_LE(read, exact[i] + 1.1 * kProximityVoxel);
    EXPECT_GE(read, exact[i] / std::sqrt(3.0) - 1.01 * kProximityVoxel);
    inside += read == 0 && exact[i] == 0 ? 1 : 0;
  }
  EXPECT_GT(beyond, 1000);
  EXPECT_GT(inside, 1000);
  // a second map lowers what it is nearer to, and nothing else
  std::vector<float> lower(points.size(), 0.0015F);
  LowerDistances(points, X_BA, box.voxmap, lower);
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(lower[i], std::min(distances[i], 0.0015F));
  }
}

TEST(ProximityColour, IsWarmNearColdFarAndConstantBeyondTheRange) {
  const auto warmth = [](double distance) {
    const std::array<float, 3> colour = ProximityColour(distance, 0.008);
    return colour[0] - colour[2];
  };
  for (int i = 0; i < 80; ++i) EXPECT_GE(warmth(1e-4 * i) + 1e-6, warmth(1e-4 * (i + 1))) << i;
  EXPECT_GT(warmth(0), 0.7F);
  EXPECT_LT(warmth(0.0079), -0.4F);
  EXPECT_EQ(ProximityColour(0.008, 0.008), ProximityColour(1e9, 0.008));
  EXPECT_EQ(ProximityColour(std::numeric_limits<double>::infinity(), 0.008),
            ProximityColour(0.008, 0.008));
}

TEST(Proximity, AllocatesNothing) {
  const ProximityShape plate = ShapeOf(At(Box(Vec3(0.1, 0.08, 0.01)), kOff));
  const ProximityShape body = ShapeOf(At(Sphere(0.01, 3), kOff));
  ProximityPair pair(body, plate);
  std::vector<Vec3> shadow(1000);
  const std::vector<std::array<float, 3>> points(100, {0.0F, 0.0F, 0.007F});
  std::vector<float> distances(100, 1.0F);
  const Pose X_BA{Quat::Identity(), Vec3(0, 0, 0.018)};
  const AllocationCounter allocations;
  Nearness near = pair.Nearest(X_BA);
  const ShadowCount count = pair.Shadow(X_BA, 0.005, shadow);
  LowerDistances(points, Pose{}, plate.voxmap, distances);
  const Vec3 gradient = VoxelGradient(plate, Vec3(0, 0, 0.008));
  near = pair.Nearest(X_BA, {.refine = false});
  EXPECT_EQ(allocations.count(), 0);
  EXPECT_GT(count.found, 0U);
  EXPECT_LT(distances[0], 1.0F);
  EXPECT_GT(gradient.z(), 0.9);
  EXPECT_NEAR(near.distance, 0.003, kBound);
}

}  // namespace
}  // namespace tandem
