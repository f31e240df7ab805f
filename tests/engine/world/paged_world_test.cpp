#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "engine/world/world.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/paged_model.h"

namespace tandem {
namespace {

using testing::DelayedPages;
using testing::FreeInputs;
using testing::HandTo;
using testing::PagedModel;
using testing::Washboard;

struct Paged {
  explicit Paged(const WorldModel& whole)
      : pages(std::make_shared<DelayedPages>(whole.fixture)),
        world(std::make_unique<World>(PagedModel(whole, pages))) {}

  std::shared_ptr<DelayedPages> pages;
  std::unique_ptr<World> world;
};

StepInputs::Hand HandAt(const WorldModel& model, int frame) {
  const Pose& start = model.bodies[0].X_WB0;
  const double x = 0.0004 * frame;
  return HandTo(model, 0, {start.q, start.p + Vec3(x, 0.004 * std::sin(9 * x), -0.008)});
}

bool SamePose(const World& a, const World& b) {
  return std::memcmp(&a.state(0).X_WB, &b.state(0).X_WB, sizeof(Pose)) == 0 &&
         std::memcmp(&a.state(0).V_WB, &b.state(0).V_WB, sizeof(Twist)) == 0;
}

TEST(PagedWorld, MatchesAnUnpagedWorldExceptWaitingFrames) {
  const auto model = Washboard();
  World whole(model);
  Paged paged(*model);
  StepInputs inputs = FreeInputs(*model);
  int waits = 0;
  int contacts = 0;
  for (int frame = 0; frame < 9000; ++frame) {
    inputs.hand = HandAt(*model, frame);
    contacts += whole.Step(inputs).contact_points;
    const Pose before = paged.world->state(0).X_WB;
    // no page comes from now and then on, until it is waited for
    if (frame % 200 == 0) paged.pages->Close();
    int waited = 0;
    while (paged.world->Step(inputs).waited > 0) {
      if (waited == 5) paged.pages->Open();
      ASSERT_EQ(std::memcmp(&before, &paged.world->state(0).X_WB, sizeof before), 0);
      std::this_thread::sleep_for(std::chrono::microseconds(100));
      ASSERT_LT(++waited, 20000);
    }
    waits += waited > 0 ? 1 : 0;
    ASSERT_TRUE(SamePose(whole, *paged.world)) << frame;
  }
  EXPECT_GT(waits, 10);
  EXPECT_GT(contacts, 9000);
  EXPECT_GT(whole.state(0).X_WB.p.x(), 2.0) << "it did not come far";
  EXPECT_GT(paged.world->resident_voxels()->counts().pages_given_up, 0U);
}

TEST(PagedWorld, DoesNotWaitForPagesWithinTenFrames) {
  const auto model = Washboard();
  Paged paged(*model);
  StepInputs inputs = FreeInputs(*model);
  int waits = 0;
  for (int frame = 0; frame < 6000; ++frame) {
    inputs.hand = HandAt(*model, frame);
    waits += paged.world->Step(inputs).waited > 0 ? 1 : 0;
    // pages asked for in the last ten frames come now, and none in between
    if (frame % 10 != 0) continue;
    paged.pages->Open();
    paged.world->WaitForVoxels();
    paged.pages->Close();
  }
  EXPECT_EQ(waits, 0);
  EXPECT_GT(paged.pages->order().size(), 5U);
}

TEST(PagedWorld, StandsWithoutForceWhileVoxelsAreMissing) {
  const auto model = Washboard();
  Paged paged(*model);
  paged.pages->Close();
  StepInputs inputs = FreeInputs(*model);
  int frame = 0;
  do {
    inputs.hand = HandAt(*model, frame);
    ASSERT_LT(++frame, 9000) << "nothing was waited for";
  } while (paged.world->Step(inputs).waited == 0);
  const Pose stands = paged.world->state(0).X_WB;
  const testing::AllocationCounter allocations;
  for (int k = 2; k < 2500; ++k) {
    inputs.hand = HandAt(*model, frame + k);
    const StepReport& report = paged.world->Step(inputs);
    ASSERT_EQ(report.waited, k);
    ASSERT_EQ(report.flags, StepReport::kWaitsForVoxels);
    ASSERT_EQ(report.hand_B_W.f, Vec3::Zero());
    ASSERT_EQ(report.contact_B_W.f, Vec3::Zero());
  }
  EXPECT_EQ(allocations.count(), 0);
  EXPECT_EQ(std::memcmp(&stands, &paged.world->state(0).X_WB, sizeof stands), 0);
  EXPECT_NE(paged.world->MissingVoxelsReason().find("--voxel-memory"), std::string::npos);
  paged.pages->Open();
  inputs.hand = HandAt(*model, frame);
  for (int k = 0; k < 20000 && paged.world->Step(inputs).waited > 0; ++k) {
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  for (int k = 0; k < 50; ++k) paged.world->Step(inputs);
  EXPECT_NE(std::memcmp(&stands, &paged.world->state(0).X_WB, sizeof stands), 0);
}

TEST(PagedWorld, ReportsDiskErrors) {
  const auto model = Washboard();
  Paged paged(*model);
  paged.pages->Break();
  StepInputs inputs = FreeInputs(*model);
  for (int frame = 0; frame < 9000; ++frame) {
    inputs.hand = HandAt(*model, frame);
    if (paged.world->Step(inputs).waited > 0) break;
  }
  for (int k = 0; k < 2000 && paged.world->resident_voxels()->fault() == nullptr; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(paged.world->MissingVoxelsReason(), "the disk is broken");
}

}  // namespace
}  // namespace tandem
