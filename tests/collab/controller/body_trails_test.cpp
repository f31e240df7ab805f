#include "collab/controller/body_trails.h"

#include <gmock/gmock.h>

#include "tests/collab/controller/fake_peer.h"

namespace tandem {
namespace {

using testing::FourBodies;

class BodyTrailsTest : public ::testing::Test {
 protected:
  void MoveTo(int moving, const Vec3& p_WB) {
    facts_.bodies[static_cast<std::size_t>(moving)].X_WB.p = p_WB;
    trails_.See(facts_, scene_);
  }
  ControlScene scene_ = FourBodies();
  SimulationFacts facts_{.body_count = 3};
  BodyTrails trails_;
};

TEST_F(BodyTrailsTest, WayBeginsAtTheFirstPlaceAndHasAPoseForEachStep) {
  MoveTo(0, Vec3::Zero());
  EXPECT_THAT(trails_.Displaced(), ::testing::IsEmpty());
  // 20 mm in steps of 0.1 mm
  for (int i = 1; i <= 200; ++i) MoveTo(0, Vec3(1e-4 * i, 0, 0));
  EXPECT_THAT(trails_.Displaced(), ::testing::ElementsAre(0));
  ASSERT_NEAR(static_cast<double>(trails_.way(0).size()), 21, 1);
  EXPECT_EQ(trails_.way(0).front().p, Vec3::Zero());
  EXPECT_NEAR(trails_.way(0).back().p.x(), 0.020, BodyTrails::kStep);
}

TEST_F(BodyTrailsTest, LoopsAreForgottenAndTheWayHomeEmptiesIt) {
  // a square of 20 mm, back to a point of its first side
  for (const Vec3& corner :
       {Vec3(0.02, 0, 0), Vec3(0.02, 0.02, 0), Vec3(0.01, 0.02, 0), Vec3(0.01, 0, 0)}) {
    const Vec3 from = facts_.bodies[0].X_WB.p;
    for (int i = 1; i <= 40; ++i) MoveTo(0, from + i / 40.0 * (corner - from));
  }
  EXPECT_NEAR(static_cast<double>(trails_.way(0).size()), 11, 2) << "10 mm, not 70";
  for (int i = 40; i >= 0; --i) MoveTo(0, Vec3(0.01 * i / 40.0, 0, 0));
  EXPECT_THAT(trails_.Displaced(), ::testing::IsEmpty());
}

TEST_F(BodyTrailsTest, BodyThatMovedLastComesFirst) {
  MoveTo(0, Vec3(0.01, 0, 0));
  MoveTo(1, Vec3(0.01, 0, 0));
  EXPECT_THAT(trails_.Displaced(), ::testing::ElementsAre(1, 0));
  MoveTo(0, Vec3(0.02, 0, 0));
  EXPECT_THAT(trails_.Displaced(), ::testing::ElementsAre(0, 1));
}

TEST_F(BodyTrailsTest, LongWayIsBoundedAndKeepsItsEnds) {
  for (int i = 1; i <= 5000; ++i) MoveTo(0, Vec3(2e-3 * i, 0, 0));
  EXPECT_LE(trails_.way(0).size(), BodyTrails::kMost);
  EXPECT_EQ(trails_.way(0).front().p.x(), 0);
  EXPECT_NEAR(trails_.way(0).back().p.x(), 10.0, 1e-9);
  for (std::size_t i = 1; i < trails_.way(0).size(); ++i) {
    ASSERT_GT(trails_.way(0)[i].p.x(), trails_.way(0)[i - 1].p.x());
  }
}

TEST_F(BodyTrailsTest, AnotherSceneBeginsAnew) {
  MoveTo(0, Vec3(0.01, 0, 0));
  scene_.number = 2;
  facts_.bodies[0].X_WB = {};
  trails_.See(facts_, scene_);
  EXPECT_THAT(trails_.Displaced(), ::testing::IsEmpty());
}

}  // namespace
}  // namespace tandem
