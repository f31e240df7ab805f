#include "scenes/landing_gear.h"

#include <gtest/gtest.h>

#include "scenes/clutter.h"

namespace tandem {
namespace {

// The paper's scene (section 7, table 1): 4.1 x 1.9 x 4.8 m, 2.76e6 triangles. How many voxels it
// has is measured by the benches.
TEST(LandingGear, IsAsLargeAsThePapersAndItsPartsDoNotOverlap) {
  const std::vector<TriangleMesh> parts = LandingGearParts();
  const GeneratedScene scene = LandingGear(parts);
  const TriangleMesh& fixed = scene.meshes[0].mesh;
  const Vec3 size = 1e-3 * BoundsOf(fixed).size();
  EXPECT_NEAR(size.x(), 4.1, 0.02);
  EXPECT_NEAR(size.y(), 1.9, 0.02);
  EXPECT_NEAR(size.z(), 4.8, 0.02);
  EXPECT_NEAR(static_cast<double>(fixed.triangles.size()), 2.76e6, 0.01 * 2.76e6);
  EXPECT_LT(OverlapShare(parts), 0.002);
}

TEST(LandingGear, IsTheSameEachTimeItIsMade) {
  const std::vector<TriangleMesh> once = LandingGearParts();
  const std::vector<TriangleMesh> again = LandingGearParts();
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t k = 0; k < once.size(); ++k) {
    ASSERT_EQ(once[k].vertices, again[k].vertices);
  }
}

}  // namespace
}  // namespace tandem
