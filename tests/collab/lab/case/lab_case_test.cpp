#include "collab/lab/case/lab_case.h"

#include <gmock/gmock.h>

namespace tandem {
namespace {

using ::testing::HasSubstr;

// A cube of 0.3 kg: its turn about an axis at the hand's mass is as the hand's travel.
TEST(LabHands, RotateAsTheyTravel) {
  const Inertia cube{0.3, 8e-5 * Mat3::Identity()};
  const Result<LabHand> hand = HandNamed("firm", cube);
  ASSERT_TRUE(hand);
  const HandImpedance& firm = hand->impedance;
  EXPECT_DOUBLE_EQ(firm.mass, 1.2);
  EXPECT_DOUBLE_EQ(firm.damping, 10.3);
  EXPECT_DOUBLE_EQ(firm.stiffness, 800);
  EXPECT_NEAR(firm.inertia / firm.mass, 8e-5 / 0.3, 1e-12);
  EXPECT_NEAR(firm.rotation_stiffness / firm.inertia, firm.stiffness / firm.mass, 1e-9);
  EXPECT_NEAR(firm.rotation_damping / firm.inertia, firm.damping / firm.mass, 1e-9);
}

TEST(LabHands, UnknownHandIsNamed) {
  const Result<LabHand> hand = HandNamed("iron", Inertia{});
  ASSERT_FALSE(hand);
  EXPECT_THAT(hand.error().what, HasSubstr("'iron': there are off, relaxed, heavy and firm"));
}

TEST(LabCase, LastsFortyDelaysAndAtLeastTwelveSeconds) {
  LabCase test;
  EXPECT_EQ(test.DefaultDuration(), 12);
  test.delay_s = 1;
  EXPECT_EQ(test.DefaultDuration(), 40);
}

}  // namespace
}  // namespace tandem
