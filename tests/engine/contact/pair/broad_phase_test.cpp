#include "engine/contact/pair/broad_phase.h"

#include <limits>

#include <gtest/gtest.h>

#include "engine/contact/pair/contact_pair.h"
#include "engine/voxel/build/voxelize.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::Box;
using testing::RandomDirection;
using testing::RandomRotation;
using testing::Sphere;
using testing::Uniform;

constexpr double kEver = std::numeric_limits<double>::infinity();

Pose RandomPoseWithin(std::mt19937_64& random, double reach) {
  return {RandomRotation(random), Uniform(random, 0, reach) * RandomDirection(random)};
}

/// Returns the place in a box that is nearest to p, both in A.
Vec3 Nearest(const Extent& box, const Vec3& p) {
  return p.cwiseMax(box.centre - box.half_size).cwiseMin(box.centre + box.half_size);
}

struct Distance {
  double most;   // distance between two places, one in each box
  double least;  // width of a slab that no box enters; below zero where there is none
};

/// Returns how far a box reaches along a direction, in A.
double Reach(const Extent& box, const Pose& X_AB, const Vec3& n) {
  const Vec3 n_B = X_AB.q.conjugate() * n;
  return n.dot(X_AB * box.centre) + n_B.cwiseAbs().dot(box.half_size);
}

/// Finds the distance of two boxes by going to and fro between them: both bounds meet in the limit.
Distance DistanceByProjections(const Extent& a, const Extent& b, const Pose& X_AB) {
  Vec3 p = a.centre;
  Vec3 q = p;
  for (int k = 0; k < 2000; ++k) {
    q = X_AB * Nearest(b, X_AB.Inverse() * p);
    p = Nearest(a, q);
  }
  const Vec3 n = (q - p).normalized();
  return {(q - p).norm(), -Reach(b, X_AB, -n) - Reach(a, Pose{}, n)};
}

Extent RandomBox(std::mt19937_64& random) {
  Extent box;
  box.centre = Uniform(random, 0, 0.5) * RandomDirection(random);
  for (double& half : box.half_size) half = std::pow(10.0, Uniform(random, -2, 0));
  box.radius = box.half_size.norm();
  return box;
}

TEST(GapBetween, IsNeverMoreThanTheDistanceAndAboveZeroWheneverTheBoxesAreApart) {
  std::mt19937_64 random(31);
  int apart = 0;
  int near = 0;
  double ratios = 0;
  for (int trial = 0; trial < 10000; ++trial) {
    const Extent a = RandomBox(random);
    const Extent b = RandomBox(random);
    const Pose X_AB = RandomPoseWithin(random, 3.0);
    const Distance distance = DistanceByProjections(a, b, X_AB);
    const double gap = GapBetween(a, b, X_AB, kEver);
    ASSERT_LE(gap, distance.most + 1e-9) << "trial " << trial;
    if (!(distance.least > 1e-6)) continue;
    ++apart;
    near += distance.most < 0.1 ? 1 : 0;
    ratios += gap / distance.most;
    ASSERT_GT(gap, 0.0) << "trial " << trial << ", distance " << distance.least;
  }
  EXPECT_GT(apart, 4000);
  EXPECT_GT(near, 200);
  EXPECT_GT(ratios / apart, 0.95);  // most of the distance is known
}

TEST(GapBetween, IsTheSameSeenFromTheOtherBody) {
  std::mt19937_64 random(32);
  for (int trial = 0; trial < 1000; ++trial) {
    const Extent a = RandomBox(random);
    const Extent b = RandomBox(random);
    const Pose X_AB = RandomPoseWithin(random, 3.0);
    EXPECT_NEAR(GapBetween(a, b, X_AB, kEver), GapBetween(b, a, X_AB.Inverse(), kEver), 1e-12);
  }
}

TEST(GapBetween, IsTheDistanceOfParallelBoxes) {
  const Extent box{Vec3::Zero(), Vec3(1, 2, 3), std::sqrt(14.0)};
  for (const Vec3& way : {Vec3(0.5, 0, 0), Vec3(0.3, -0.4, 0), Vec3(0.1, 0.2, -0.2)}) {
    const Vec3 sign = way.array().sign().matrix();
    const Pose X_AB{Quat::Identity(), way + 2.0 * box.half_size.cwiseProduct(sign)};
    EXPECT_NEAR(GapBetween(box, box, X_AB, kEver), way.norm(), 1e-12);
  }
}

// A shell's points are compared with the cells of all voxels with a mark, each with each.
TEST(GapBetween, IsNeverMoreThanThatOfAnyPointFromAnyMark) {
  std::mt19937_64 random(33);
  const double s = 0.004;
  Result<Voxmap> voxmap = Voxelize(Box(Vec3(0.09, 0.02, 0.03)), {.voxel_size = s});
  ASSERT_TRUE(voxmap);
  Result<Pointshell> shell = MakePointshell(Box(Vec3(0.02, 0.06, 0.02)), Pose{}, {.spacing = s});
  ASSERT_TRUE(shell);
  std::vector<Vec3> cells_V;
  const Vec3 size = voxmap->extent() / s;
  for (int z = 0; z < size.z(); ++z) {
    for (int y = 0; y < size.y(); ++y) {
      for (int x = 0; x < size.x(); ++x) {
        for (const Field field : kAllFields) {
          if (voxmap->Value(field, {x, y, z}) == voxmap->beyond()) continue;
          cells_V.push_back(s * Vec3(x + 0.5, y + 0.5, z + 0.5));
          break;
        }
      }
    }
  }
  ASSERT_GT(cells_V.size(), 5000U);
  const Extent points = ExtentOf(*shell);
  const Extent marks = ExtentOf(*voxmap);
  int positive = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Pose X_VS = Pose{RandomRotation(random),
                           marks.centre + Uniform(random, 0.02, 0.25) * RandomDirection(random)};
    double least = kEver;
    for (std::size_t i = 0; i < shell->size(); ++i) {
      const Vec3 p = X_VS * shell->point(i);
      for (const Vec3& cell : cells_V) {
        const Vec3 outside = ((p - cell).cwiseAbs().array() - 0.5 * s).max(0.0).matrix();
        least = std::min(least, outside.squaredNorm());
      }
    }
    const double gap = GapBetween(marks, points, X_VS, kEver);
    positive += gap > 0 ? 1 : 0;
    EXPECT_LE(gap, std::sqrt(least) + 1e-9) << "trial " << trial;
  }
  EXPECT_GT(positive, 15);
}

// Two long bars wander about each other. In each frame the pair finds what a reading of every point
// finds, with points that are moved along their normals too. Where the boxes are apart it tests
// nothing, though the bars' balls overlap all the time.
TEST(BroadPhase, RejectedPairTestsNothingAndMissesNoContact) {
  std::mt19937_64 random(34);
  const double s = 0.002;
  const Result<Voxmap> voxmap = Voxelize(Box(Vec3(0.3, 0.02, 0.02)), {.voxel_size = s});
  ASSERT_TRUE(voxmap);
  const Result<Pointshell> shell =
      MakePointshell(Box(Vec3(0.02, 0.3, 0.02)), Pose{}, {.spacing = s});
  ASSERT_TRUE(shell);
  const Pose X_BV{Quat::Identity(), voxmap->p_WVo()};
  const PairOptions options{.force_layer = 2};
  ContactPair pair(*shell, *voxmap, X_BV, 0.16, options, {1e4, 0});
  ContactPair reader(*shell, *voxmap, X_BV, 0.16, options, {1e4, 0});
  int rejected = 0;
  int touching = 0;
  Pose X_W;
  Vec3 turn = Vec3::Zero();
  for (int frame = 0; frame < 6000; ++frame) {
    if (frame % 200 == 0) turn = 1e-3 * RandomDirection(random);
    // up and down through the force layer
    const double height = 0.03 + 0.045 * (1 + std::cos(0.004 * frame)) / 2;
    X_W = {(RotationBy(turn) * X_W.q).normalized(), Vec3(0.01 * std::sin(0.01 * frame), 0, height)};
    LinearizedForce on_shell;
    LinearizedForce on_map;
    const PairReport report = pair.Collide({X_W, {}}, {Pose{}, {}}, on_shell, on_map);
    const PoseReading reading = reader.Read({X_W, {}}, {Pose{}, {}});
    ASSERT_EQ(report.contact_points, reading.contact_points) << "frame " << frame;
    touching += report.contact_points > 0 ? 1 : 0;
    if (GapBetween(ExtentOf(*voxmap), ExtentOf(*shell), X_BV.Inverse() * X_W, kEver) > 0) {
      ASSERT_EQ(report.tests.looked_up + report.tests.drifted + report.tests.chunks, 0U);
      ++rejected;
    }
  }
  EXPECT_GT(rejected, 1000);
  EXPECT_GT(touching, 200);
}

TEST(BroadPhase, AccountsForDisplacedPoints) {
  const double s = 0.002;
  const Result<Voxmap> voxmap = Voxelize(Box(Vec3(0.1, 0.1, 0.02)), {.voxel_size = s});
  ASSERT_TRUE(voxmap);
  const Result<Pointshell> shell = MakePointshell(Sphere(0.02, 3), Pose{}, {.spacing = s});
  ASSERT_TRUE(shell);
  ContactPair pair(*shell, *voxmap, {Quat::Identity(), voxmap->p_WVo()}, 0.08, {.force_layer = 1},
                   {1e4, 0});
  const Pose X_W{Quat::Identity(), Vec3(0, 0, 0.09)};
  LinearizedForce load;
  EXPECT_EQ(pair.Collide({X_W, {}}, {Pose{}, {}}, load, load).contact_points, 0);
  // normals point into the ball
  pair.SetClearance({1.0, -0.06});
  EXPECT_GT(pair.Collide({X_W, {}}, {Pose{}, {}}, load, load).contact_points, 0);
}

}  // namespace
}  // namespace tandem
