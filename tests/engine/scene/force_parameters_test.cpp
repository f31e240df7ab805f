#include "engine/scene/force_parameters.h"

#include <gtest/gtest.h>

#include "engine/contact/pair/tangent_plane.h"

namespace tandem {
namespace {

ForceParameters Refined(double voxel_size) {
  return {.voxel_size = voxel_size,
          .contact = ContactModel::kRefined,
          .force_layer = 1,
          .friction = 0,
          .stiffness = LeastContactStiffness(voxel_size)};
}

TEST(ForceParameters, AreCopiedBetweenScenes) {
  Scene from;
  from.voxel_size = 0.002;
  from.contact = ContactModel::kPlain;
  from.force_layer = 3;
  from.friction = 0.25;
  Scene to;
  Adopt(ParametersOf(from), to);
  EXPECT_EQ(ParametersOf(to), ParametersOf(from));
  EXPECT_EQ(Describe(ParametersOf(to)),
            "voxels of 2 mm, plain contact, force layer 3, friction 0.25");
}

TEST(ForceParameters, HashCoversEachParameter) {
  const ForceParameters plain = Refined(0.001);
  ForceParameters other = plain;
  EXPECT_EQ(HashOf(other), HashOf(plain));
  other.friction = -0.0;
  EXPECT_EQ(HashOf(other), HashOf(plain));
  other.friction = 0.1;
  EXPECT_NE(HashOf(other), HashOf(plain));
  other = plain;
  other.stiffness *= 2;
  EXPECT_NE(HashOf(other), HashOf(plain));
}

// 0.45 voxels: from 0.45 mm on with 1 mm, from 0.9 mm with 2 mm. At 0.45 mm of depth one point of a
// 0.1 kg body gives K (d - s/20 + 8 d (d/s)^3) with K = max(50/2 mm, 0.1/4 / (1 ms)^2) = 25 kN/m:
// 25e3 * (0.35e-3 + 0.45e-3 * 8 * 0.225^3) = 9.775 N.
TEST(ForceParameters, SmallerVoxelsPushHarder) {
  const auto push = ComparePush(Refined(0.001), Refined(0.002), 0.1);
  ASSERT_TRUE(push.has_value());
  EXPECT_TRUE(push->first_harder);
  EXPECT_NEAR(push->head_start, 0.45e-3, 1e-12);
  EXPECT_NEAR(push->alone_force, 9.775, 1e-3);
  const auto swapped = ComparePush(Refined(0.002), Refined(0.001), 0.1);
  ASSERT_TRUE(swapped.has_value());
  EXPECT_FALSE(swapped->first_harder);
  EXPECT_EQ(swapped->alone_force, push->alone_force);
}

TEST(ForceParameters, AtEqualVoxelSizePlainContactStartsEarlierAndYields) {
  ForceParameters plain = Refined(0.001);
  plain.contact = ContactModel::kPlain;
  plain.force_layer = 2;
  const auto push = ComparePush(plain, Refined(0.001), 0.1);
  ASSERT_TRUE(push.has_value());
  EXPECT_FALSE(push->first_harder);
  EXPECT_NEAR(push->head_start, 2e-3 - 0.45e-3, 1e-12);
}

TEST(ForceParameters, AtEqualOnsetTheSofterContactPushesHarder) {
  ForceParameters stiff = Refined(0.001);
  stiff.stiffness *= 3;
  const auto push = ComparePush(stiff, Refined(0.001), 0.01);
  ASSERT_TRUE(push.has_value());
  EXPECT_FALSE(push->first_harder);
  EXPECT_NEAR(push->ratio, 3.0, 1e-12);
  EXPECT_EQ(push->head_start, 0.0);
  // a heavy body's points are stiff enough for its mass alone, with either
  EXPECT_FALSE(ComparePush(stiff, Refined(0.001), 10).has_value());
}

TEST(ForceParameters, FrictionAloneDoesNotChangeThePush) {
  ForceParameters rough = Refined(0.001);
  rough.friction = 0.5;
  EXPECT_FALSE(ComparePush(rough, Refined(0.001), 0.1).has_value());
}

}  // namespace
}  // namespace tandem
