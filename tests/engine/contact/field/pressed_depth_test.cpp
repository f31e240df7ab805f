#include "engine/contact/field/pressed_depth.h"

#include <cmath>

#include <gtest/gtest.h>

namespace tandem {
namespace {

// 50 N a voxel, 8 (d / s)^3 harder, less the soft beginning: x + 8 x^4 = F / 50 + 0.05, and force
// begins 0.02 voxels from the surface.
TEST(ContactYield, RefinedDepthSolvesTheSpringsEquation) {
  for (const double force : {4.0, 10.0, 30.0}) {
    for (const double voxel : {0.001, 0.0001}) {
      const double x = 0.02 + ContactYield{.voxel_size = voxel, .force = force}.PressedDepth() / voxel;
      EXPECT_NEAR(x + 8 * std::pow(x, 4), force / 50 + 0.05, 1e-9);
    }
  }
}

TEST(ContactYield, TheVoxelThatDecidesGivesWayByHalfOfTheDepth) {
  const ContactYield yield{.voxel_size = 0.0005};
  for (const double depth : {0.5e-4, 1e-4, 4e-4}) {
    const double voxel = yield.VoxelThatDecides(depth);
    const double pressed = ContactYield{.voxel_size = voxel}.PressedDepth();
    EXPECT_LE(pressed, 0.5 * depth * (1 + 1e-9));
    EXPECT_GE(pressed, 0.4 * depth);
  }
}

TEST(ContactYield, AShiftBeginsForceAsMuchDeeper) {
  const ContactYield flush{.voxel_size = 1};
  const ContactYield shifted{.inward_shift_voxels = 0.5, .voxel_size = 1};
  EXPECT_NEAR(shifted.PressedDepth() - flush.PressedDepth(), 0.02 + 0.05, 1e-9);
}

TEST(ContactYield, PlainContactOfTheDefaultLayerKeepsSurfacesApart) {
  ContactYield yield{.contact = ContactModel::kPlain, .force_layer = 2, .voxel_size = 0.001};
  EXPECT_EQ(yield.PressedDepth(), 0);
  EXPECT_EQ(yield.VoxelThatDecides(1e-4), 0);
  yield.force_layer = 0;
  EXPECT_GT(yield.PressedDepth(), 1e-3);
}

}  // namespace
}  // namespace tandem
