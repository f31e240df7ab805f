#include "scenes/generators/large/landing_gear.h"

#include <tuple>

#include <gtest/gtest.h>

#include "engine/voxel/points/pointshell.h"
#include "scenes/generators/large/clutter.h"
#include "tests/scenes/generators/solid_probe.h"

namespace tandem {
namespace {

// The scene is the paper's (section 7, table 1): 4.1 x 1.9 x 4.8 m, 2.76e6 triangles. The benches
// measure how many voxels it has.
TEST(LandingGear, HasThePapersSizeAndDisjointParts) {
  const std::vector<TriangleMesh> parts = MakeLandingGear(LandingGearParts::kAll);
  const GeneratedScene scene = LandingGear(parts);
  const TriangleMesh& fixed = scene.meshes[0].mesh;
  const Vec3 size = 1e-3 * BoundsOf(fixed).size();
  EXPECT_NEAR(size.x(), 4.1, 0.02);
  EXPECT_NEAR(size.y(), 1.9, 0.02);
  EXPECT_NEAR(size.z(), 4.8, 0.02);
  EXPECT_NEAR(static_cast<double>(fixed.triangles.size()), 2.76e6, 0.01 * 2.76e6);
  EXPECT_LT(OverlapShare(parts), 0.002);
}

TEST(LandingGear, HasThePapersActuator) {
  const std::vector<TriangleMesh> nest = MakeLandingGear(LandingGearParts::kNest);
  const GeneratedScene scene = LandingGear(nest);
  const TriangleMesh& actuator = scene.meshes[1].mesh;
  EXPECT_TRUE(ClosedAndTurnedOutward(actuator));
  EXPECT_NEAR(static_cast<double>(actuator.triangles.size()), 40476, 0.01 * 40476);
  const Vec3 size = 1e-3 * BoundsOf(actuator).size();
  EXPECT_NEAR(size.x(), 0.9, 0.05);
  EXPECT_NEAR(size.y(), 0.2, 0.05);
  EXPECT_NEAR(size.z(), 0.2, 0.05);
  // table 1: its points a millimetre and 0.7 mm apart
  for (const auto& [spacing, points, share] :
       {std::tuple(1e-3, 528653.0, 0.05), std::tuple(0.7e-3, 1.14e6, 0.08)}) {
    TriangleMesh in_metres = actuator;
    for (Vec3& v : in_metres.vertices) v *= 1e-3;
    const Result<Pointshell> shell = MakePointshell(in_metres, Pose{}, {.spacing = spacing});
    ASSERT_TRUE(shell) << shell.error().what;
    EXPECT_NEAR(static_cast<double>(shell->size()), points, share * points);
  }
}

TEST(LandingGear, IsDeterministic) {
  const std::vector<TriangleMesh> once = MakeLandingGear(LandingGearParts::kAll);
  const std::vector<TriangleMesh> again = MakeLandingGear(LandingGearParts::kAll);
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t k = 0; k < once.size(); ++k) {
    ASSERT_EQ(once[k].vertices, again[k].vertices);
  }
}

}  // namespace
}  // namespace tandem
