#include "scenes/generators/large/clutter.h"

#include <cmath>

#include <gmock/gmock.h>

#include "scenes/generators/large/clutter_parts.h"
#include "scenes/generators/large/machine_parts.h"
#include "scenes/generators/large/seeded_poses.h"
#include "tests/scenes/generators/solid_probe.h"

namespace tandem {
namespace {

TEST(MachineParts, AreClosedAndTurnedOutward) {
  for (const TriangleMesh& part : {Tube(3, 5, 0, 20, 24), Gear({}), PerforatedPlate({}),
                                   Spring(20, 3, 10, 4, 10), Rack({}), BoltCircle(5, 40, 10)}) {
    EXPECT_TRUE(ClosedAndTurnedOutward(part)) << part.triangles.size();
  }
}

TEST(ClutterParts, EveryRandomPartIsClosedAndOriented) {
  RandomSource rng(7);
  for (int k = 0; k < 60; ++k) {
    EXPECT_TRUE(ClosedAndTurnedOutward(PartByChance(rng))) << "part " << k;
  }
  EXPECT_TRUE(ClosedAndTurnedOutward(Beam(900, 100, 80, rng)));
  EXPECT_TRUE(ClosedAndTurnedOutward(
      PipeRun({{0, 0, 0}, {300, 0, 0}, {600, 0, 0}, {900, 0, 0}, {900, 300, 0}}, 25, rng)));
}

// half of one box stands in the other: 4 of its 8 vertices, of 16 in all, and none of the other's
TEST(OverlapShare, IsTheShareOfVerticesInsideAnotherPart) {
  const TriangleMesh large = Box({0, 0, 0}, {10, 10, 10});
  const TriangleMesh small = Box({5, 4, 4}, {15, 6, 6});
  EXPECT_DOUBLE_EQ(OverlapShare({large, small}), 0.25);
  EXPECT_DOUBLE_EQ(OverlapShare({large, Moved(small, {6, 0, 0})}), 0);
}

TEST(Clutter, IsTheSameEachTimeAndItsPartsDoNotOverlap) {
  const ClutterShape small{.cells = {6, 3, 4}, .filled = 0.9, .seed = 3};
  const std::vector<TriangleMesh> parts = ClutterParts(small);
  const std::vector<TriangleMesh> again = ClutterParts(small);
  ASSERT_EQ(parts.size(), again.size());
  EXPECT_GT(parts.size(), 25U);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    EXPECT_EQ(parts[k].vertices, again[k].vertices);
    EXPECT_TRUE(ClosedAndTurnedOutward(parts[k])) << "part " << k;
  }
  EXPECT_LT(OverlapShare(parts), 1e-3);
}

TEST(ClutterActuator, HasItsSizeAndHalfAMillionPointsAtOneMillimetre) {
  const TriangleMesh actuator = ClutterActuator();
  EXPECT_TRUE(ClosedAndTurnedOutward(actuator));
  const Vec3 size = BoundsOf(actuator).size();
  EXPECT_NEAR(size.x(), 900, 20);
  EXPECT_LT(size.y(), 142);
  EXPECT_LT(size.z(), 142);
  // about 1.2 points a voxel face
  EXPECT_NEAR(1.2 * AreaOf(actuator), 5e5, 3e4);
}

// The samples of the search are judged by the distances of a probe that knows nothing of it.
TEST(SeededPoses, HaveTheirStatedDistance) {
  const TriangleMesh nest = ClutterNest();
  const TriangleMesh actuator = ClutterActuator();
  const SolidProbe probe(nest, 12);
  const std::vector<Vec3> samples = SurfaceSamples(actuator, 1.5);
  const std::vector<SeededPose> poses = SeededPoses({.fixed_file = "a",
                                                     .moving_file = "b",
                                                     .fixed = &nest,
                                                     .moving = &actuator,
                                                     .push = {0, 0, -1},
                                                     .spread = 0.7,
                                                     .out = {0, 0, 400},
                                                     .seed = 5},
                                                    2);
  ASSERT_EQ(poses.size(), 8U);
  for (const SeededPose& pose : poses) {
    double least = 12;
    for (const Vec3& p : samples) least = std::min(least, probe.Distance(pose.X * p));
    if (pose.kind == "assembled") {
      EXPECT_LT(least, 0.5);
      EXPECT_LT(pose.distance, 0);
    } else if (pose.kind == "far") {
      EXPECT_EQ(least, 12);
    } else {
      EXPECT_NEAR(least, pose.distance, 0.8) << pose.kind;
    }
  }
}

}  // namespace
}  // namespace tandem
