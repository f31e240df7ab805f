#include "app/judgement/penetration_oracle.h"

#include <algorithm>
#include <atomic>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/solid_meshes.h"

namespace tandem {
namespace {

using testing::BoxBetween;
using testing::BoxOfHalf;
using testing::GlobeMesh;
using testing::Prism;

constexpr double kVoxel = 0.05;  // m

bool Never() {
  return false;
}

double In(std::mt19937& engine, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(engine);
}

Vec3 PointIn(std::mt19937& engine, double reach) {
  return {In(engine, -reach, reach), In(engine, -reach, reach), In(engine, -reach, reach)};
}

// Computes the distance to a triangle in another way than the product: to its plane if the foot
// lies within all three edges, else to the nearest edge.
double TriangleDistance(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  const Vec3 nhat = (b - a).cross(c - a).normalized();
  const auto within = [&](const Vec3& from, const Vec3& to) {
    return nhat.dot((to - from).cross(p - from)) >= 0;
  };
  if (within(a, b) && within(b, c) && within(c, a)) return std::abs(nhat.dot(p - a));
  const auto edge = [&](const Vec3& from, const Vec3& to) {
    const double share = (p - from).dot(to - from) / (to - from).squaredNorm();
    return (from + std::clamp(share, 0.0, 1.0) * (to - from) - p).norm();
  };
  return std::min({edge(a, b), edge(b, c), edge(c, a)});
}

// Tries all samples against all triangles, for fixtures whose bodies do not overlap.
double BruteForceDepth(const TriangleMesh& fixture, const std::vector<Vec3>& samples,
                       const Pose& X_FB) {
  double deepest = 0;
  for (const Vec3& p_B : samples) {
    const Vec3 p = X_FB * p_B;
    double winding = 0;
    double distance = 1e300;
    for (std::size_t t = 0; t < fixture.triangles.size(); ++t) {
      const Vec3& a = fixture.corner(t, 0);
      const Vec3& b = fixture.corner(t, 1);
      const Vec3& c = fixture.corner(t, 2);
      winding += WindingOf(a, b, c, p);
      distance = std::min(distance, TriangleDistance(a, b, c, p));
    }
    if (winding >= 0.5) deepest = std::max(deepest, distance);
  }
  return deepest;
}

TriangleMesh Fixture() {
  TriangleMesh mesh = BoxBetween(Vec3(-1, -1, -0.4), Vec3(1, 1, -0.2));
  Append(mesh, Transformed(Prism(0.2, 0.3, 12), {Quat::Identity(), Vec3(0.5, 0, 0.2)}));
  Append(mesh, Transformed(GlobeMesh(0.3, 10), {Quat::Identity(), Vec3(-0.5, 0.2, 0.2)}));
  return mesh;
}

TriangleMesh Part() {
  TriangleMesh mesh = BoxOfHalf(Vec3(0.15, 0.1, 0.05));
  Append(mesh, Prism(0.04, 0.3, 6));
  return mesh;
}

// Returns a wavering walk over the fixture, now in it, now out of it.
std::vector<Pose> Walk(unsigned seed, std::size_t count, double stride) {
  std::mt19937 engine(seed);
  std::vector<Pose> poses;
  Pose X_FB{Quat::Identity(), Vec3(0, 0, 0.1)};
  for (std::size_t i = 0; i < count; ++i) {
    X_FB.q = X_FB.q * RotationBy(PointIn(engine, stride));
    X_FB.p = (X_FB.p + PointIn(engine, stride)).cwiseMax(-0.7).cwiseMin(0.7);
    poses.push_back(X_FB);
  }
  return poses;
}

TEST(SampleSurface, LeavesNoPlaceFartherThanItsSpacingOverRootTwo) {
  std::mt19937 engine(1);
  const double spacing = 0.07;
  for (int i = 0; i < 30; ++i) {
    TriangleMesh mesh;  // triangles of all shapes, needles too
    mesh.vertices = {PointIn(engine, 0.5), PointIn(engine, 0.5), PointIn(engine, 0.5)};
    if (i % 3 == 0) {
      mesh.vertices[2] = 0.5 * (mesh.vertices[0] + mesh.vertices[1]) + PointIn(engine, 0.1);
    }
    mesh.triangles = {{0, 1, 2}};
    const std::vector<Vec3> samples = SampleSurface(mesh, spacing);
    for (const Vec3& vertex : mesh.vertices) {
      EXPECT_EQ(std::count(samples.begin(), samples.end(), vertex), 1);
    }
    for (int k = 0; k < 300; ++k) {
      double u = In(engine, 0, 1);
      double v = In(engine, 0, 1);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec3 p = mesh.vertices[0] + u * (mesh.vertices[1] - mesh.vertices[0]) +
                     v * (mesh.vertices[2] - mesh.vertices[0]);
      double nearest = 1e300;
      for (const Vec3& sample : samples) nearest = std::min(nearest, (sample - p).norm());
      EXPECT_LE(nearest, spacing / std::sqrt(2.0) + 1e-12);
    }
  }
}

TEST(SampleSurface, OmitsUnusedVertices) {
  TriangleMesh mesh = BoxOfHalf(Vec3(1, 1, 1));
  mesh.vertices.emplace_back(50, 0, 0);
  for (const Vec3& sample : SampleSurface(mesh, 0.5)) EXPECT_LT(sample.norm(), 2);
}

TEST(SampleTree, SpheresContainTheirPoints) {
  const std::vector<Vec3> samples = SampleSurface(Part(), 0.05);
  const SampleTree tree(samples);
  EXPECT_EQ(tree.points(), samples.size());
  std::vector<Vec3> leaves;
  std::vector<SampleTree::Branch> open{tree.root()};
  while (!open.empty()) {
    const SampleTree::Branch branch = open.back();
    open.pop_back();
    if (branch.leaf()) {
      leaves.push_back(tree[branch.node].centre);
      continue;
    }
    for (const SampleTree::Branch& child : {branch.Left(), branch.Right()}) {
      open.push_back(child);
      std::vector<SampleTree::Branch> below{child};
      while (!below.empty()) {
        const SampleTree::Branch b = below.back();
        below.pop_back();
        if (b.leaf()) {
          const double distance = (tree[b.node].centre - tree[branch.node].centre).norm();
          EXPECT_LE(distance, tree[branch.node].radius);
        } else {
          below.push_back(b.Left());
          below.push_back(b.Right());
        }
      }
    }
  }
  const auto less = [](const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
  };
  std::vector<Vec3> expected = samples;
  std::sort(leaves.begin(), leaves.end(), less);
  std::sort(expected.begin(), expected.end(), less);
  EXPECT_EQ(leaves, expected);
}

TEST(PenetrationOracle, AgreesWithAllSamplesAgainstAllTriangles) {
  const double voxel = 0.16;  // coarse, because there are many triangles to try
  const TriangleMesh fixture = Fixture();
  const std::vector<Vec3> samples = SampleSurface(Part(), 0.5 * voxel);
  const PenetrationOracle oracle(fixture, Part(), voxel);
  ASSERT_EQ(oracle.samples(), samples.size());
  int inside = 0;
  // near poses and far poses in one series: the memory over poses must hold for both
  std::vector<Pose> poses = Walk(2, 25, 0.01);
  const std::vector<Pose> jumps = Walk(3, 15, 0.5);
  poses.insert(poses.end(), jumps.begin(), jumps.end());
  double deepest = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double expected = BruteForceDepth(fixture, samples, poses[i]) / voxel;
    EXPECT_NEAR(oracle.PenetrationVoxels(poses[i]), expected, 1e-9) << i;
    // Check() of the series up to here shows each pose in the light of what the oracle remembers of
    // the others
    deepest = std::max(deepest, expected);
    const std::vector<std::vector<Pose>> until{{poses.begin(), poses.begin() + long(i) + 1}};
    const PenetrationReport report = oracle.Check(until, 1, Never);
    EXPECT_NEAR(report.max_penetration_voxels, deepest, 1e-9) << i;
    inside += expected > 0 ? 1 : 0;
    EXPECT_EQ(report.overlapping_poses, static_cast<std::size_t>(inside)) << i;
  }
  EXPECT_GT(inside, 5);
  EXPECT_LT(inside, 35);
}

TEST(PenetrationOracle, ReportsDepthAndPositionOfABoxInASlab) {
  // bottom at z = 0.1 - 0.01 i: first under the slab's top (z = 0) at i = 11, deepest 0.09 at i =
  // 19
  const PenetrationOracle oracle(BoxBetween(Vec3(-1, -1, -0.5), Vec3(1, 1, 0)),
                                 BoxOfHalf(Vec3(0.2, 0.2, 0.2)), kVoxel);
  std::vector<Pose> sinking;
  for (int i = 0; i < 20; ++i) {
    sinking.push_back({Quat::Identity(), Vec3(0, 0, 0.3 - 0.01 * i + 1e-7)});
  }
  const std::vector<Pose> far(30, Pose{Quat::Identity(), Vec3(0, 0, 3)});
  const PenetrationReport report = oracle.Check(std::vector{far, sinking}, 2, Never);
  EXPECT_NEAR(report.max_penetration_voxels, 0.09 / kVoxel, 1e-5);
  EXPECT_EQ(report.poses_given, 50U);
  EXPECT_EQ(report.poses_checked, 50U);
  EXPECT_DOUBLE_EQ(report.overlap_share(), 9.0 / 50.0);
  EXPECT_EQ(report.worst_series, 1U);
  EXPECT_EQ(report.worst_pose, 19U);
  EXPECT_NEAR(report.p_FWorst.z(), -0.09, 1e-6);
}

TEST(PenetrationOracle, TouchingIsNotOverlapping) {
  const PenetrationOracle oracle(BoxBetween(Vec3(-1, -1, -1), Vec3(1, 1, 0)),
                                 BoxOfHalf(Vec3(0.25, 0.25, 0.25)), 0.0625);
  EXPECT_EQ(oracle.PenetrationVoxels({Quat::Identity(), Vec3(0, 0, 0.25)}), 0.0);
  EXPECT_GT(oracle.PenetrationVoxels({Quat::Identity(), Vec3(0, 0, 0.249)}), 0.01);
}

TEST(PenetrationOracle, IsIndependentOfTheThreadCount) {
  const PenetrationOracle oracle(Fixture(), Part(), kVoxel);
  const std::vector<std::vector<Pose>> series{Walk(4, 700, 0.01), Walk(5, 333, 0.02), {}};
  const PenetrationReport one = oracle.Check(series, 1, Never);
  EXPECT_GT(one.overlapping_poses, 0U);
  EXPECT_LT(one.overlapping_poses, one.poses_given);
  for (const int threads : {2, 3}) {
    const PenetrationReport some = oracle.Check(series, threads, Never);
    EXPECT_EQ(some.max_penetration_voxels, one.max_penetration_voxels);
    EXPECT_EQ(some.overlapping_poses, one.overlapping_poses);
    EXPECT_EQ(some.poses_checked, 1033U);
    EXPECT_EQ(some.worst_series, one.worst_series);
    EXPECT_EQ(some.worst_pose, one.worst_pose);
  }
}

TEST(PenetrationOracle, SamplesEvenlyUnderATimeLimit) {
  // The part is in the fixture in one tenth of a long series, far out in the rest. In a quarter of
  // the time the oracle must find it there, in about as large a share of the poses.
  const PenetrationOracle oracle(Fixture(), Part(), kVoxel);
  constexpr std::size_t kTenth = 10 * PenetrationOracle::kBlock;
  std::vector<Pose> poses(10 * kTenth, Pose{Quat::Identity(), Vec3(0, 0, 9)});
  std::fill_n(poses.begin() + 6 * kTenth, kTenth, Pose{Quat::Identity(), Vec3(0, 0, -0.3)});
  const std::vector<std::vector<Pose>> series{poses};
  std::atomic<std::size_t> requested{0};
  const PenetrationReport report = oracle.Check(series, 2, [&] {
    return requested++ >= series[0].size() / 4;
  });
  EXPECT_EQ(report.poses_given, series[0].size());
  EXPECT_EQ(report.poses_checked, series[0].size() / 4);
  EXPECT_NEAR(report.overlap_share(), 0.1, 0.05);
  EXPECT_GT(report.max_penetration_voxels, 1.0);

  const PenetrationReport none = oracle.Check(series, 2, [] {
    return true;
  });
  EXPECT_EQ(none.poses_checked, 0U);
  EXPECT_EQ(none.overlap_share(), 0.0);
}

TEST(PenetrationReport, MergesPairsOfBodies) {
  PenetrationReport ball{.max_penetration_voxels = 0.2,
                         .overlapping_poses = 3,
                         .poses_checked = 10,
                         .poses_given = 20,
                         .worst_series = 1,
                         .worst_pose = 7};
  PenetrationReport socket = ball;
  socket.max_penetration_voxels = 0.4;
  socket.worst_series = 0;
  const PenetrationReport both = Merged(ball, socket, 2);
  EXPECT_EQ(both.max_penetration_voxels, 0.4);
  EXPECT_EQ(both.worst_series, 2U);
  EXPECT_EQ(both.poses_checked, 20U);
  EXPECT_EQ(both.poses_given, 40U);
  EXPECT_DOUBLE_EQ(both.overlap_share(), 0.3);
}

}  // namespace
}  // namespace tandem
