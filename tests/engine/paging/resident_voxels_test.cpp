#include "engine/paging/resident_voxels.h"

#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "engine/voxel/voxelize.h"
#include "tests/support/gated_pages.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::GatedPages;

constexpr double kVoxel = 0.001;
constexpr double kMiddle = 0.032;  // of a row of hyperchunks

/// A long bar along x with a ball that says where one looks.
class ResidentVoxelsTest : public ::testing::Test {
 protected:
  ResidentVoxelsTest() {
    const Result<Voxmap> whole =
        Voxelize(testing::At(testing::Box(Vec3(20.0, 0.02, 0.02)), Vec3(0, kMiddle, kMiddle)),
                 {.voxel_size = kVoxel});
    TANDEM_CHECK(whole);
    pages_ = std::make_shared<GatedPages>(*whole);
    const std::uint64_t budget = VoxelArena::FixedBytes(whole_outline()) + (1U << 20U);
    auto made = ResidentVoxels::Make(pages_, budget);
    TANDEM_CHECK(made);
    voxels_ = std::move(*made);
    reader_ = &voxels_->AddReader(Vec3::Zero(), Vec3::Constant(0.005));
    voxels_->Start();
  }

  const Voxmap& whole_outline() const { return pages_->outline(); }
  /// Where on the bar something is, in voxels of V.
  Vec3 At(double x) const { return (Vec3(x, kMiddle, kMiddle) - whole_outline().p_WVo()) / kVoxel; }
  void Go(double x) {
    reader_->MoveTo({Quat::Identity(), kVoxel * At(x)}, std::abs(x - at_) / kVoxel);
    at_ = x;
  }
  bool Announce() { return reader_->Announce(At(at_), 20, 0); }
  bool ComesSoon() {
    for (int k = 0; k < 4000; ++k) {
      voxels_->BeginFrame();
      if (Announce()) return true;
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
    return false;
  }

  std::shared_ptr<GatedPages> pages_;
  std::unique_ptr<ResidentVoxels> voxels_;
  VoxelReader* reader_ = nullptr;
  double at_ = 0;
};

TEST_F(ResidentVoxelsTest, WhatIsAnnouncedComes) {
  Go(-9.9);
  EXPECT_FALSE(Announce());
  voxels_->WaitUntilThere();
  EXPECT_TRUE(Announce());
  // free space has no pages
  EXPECT_TRUE(reader_->Announce(At(-9.9) + Vec3(0, 500, 0), 20, 0));
}

TEST_F(ResidentVoxelsTest, WhatIsReadIsNeverGivenUpForOthers) {
  Go(0);
  Announce();
  voxels_->WaitUntilThere();
  ASSERT_TRUE(Announce());
  // hints all along the bar, many more than there is room for
  for (int round = 0; round < 3; ++round) {
    for (double x = -9.9; x < 9.9; x += 0.05) {
      reader_->Hint(At(x), 10, 0);
      voxels_->BeginFrame();
    }
    voxels_->WaitUntilThere();
    EXPECT_TRUE(Announce()) << round;
  }
}

TEST_F(ResidentVoxelsTest, NothingThatMayBeReadGoesHoweverMuchIsAskedFor) {
  Go(0);
  std::vector<double> there;
  for (int round = 0; round < 4; ++round) {
    for (const double x : there) EXPECT_TRUE(reader_->Announce(At(x), 10, 0)) << x;
    there.clear();
    for (double x = -9.9; x < 9.9; x += 0.1) {
      if (reader_->Announce(At(x), 10, 0)) there.push_back(x);
    }
    voxels_->WaitUntilThere();
  }
  EXPECT_GT(there.size(), 3U);
  EXPECT_LT(there.size(), 190U) << "all of them have room";
}

TEST_F(ResidentVoxelsTest, FarPagesMakeRoomForNearOnes) {
  for (int way = 0; way < 4; ++way) {
    for (double x = -9.9; x < 9.9; x += 0.05) {
      Go(way % 2 == 0 ? x : -x);
      ASSERT_TRUE(ComesSoon()) << x;
    }
  }
  const ResidentCounts counts = voxels_->counts();
  EXPECT_GT(counts.pages_given_up, 0U);
  EXPECT_GT(counts.pages_read, counts.most_pages);
  EXPECT_LE(voxels_->bytes(), VoxelArena::FixedBytes(whole_outline()) + (1U << 20U));
}

TEST_F(ResidentVoxelsTest, TellsWhyNothingComes) {
  pages_->Break();
  Go(1);
  EXPECT_FALSE(Announce());
  voxels_->WaitUntilThere();
  ASSERT_NE(voxels_->fault(), nullptr);
  EXPECT_EQ(*voxels_->fault(), "the disk is broken");
}

TEST_F(ResidentVoxelsTest, RefusesABudgetThatHoldsNothing) {
  const auto fault = ResidentVoxels::BudgetFault(*pages_, 1U << 18U);
  ASSERT_TRUE(fault);
  EXPECT_NE(fault->what.find("it needs at least"), std::string::npos) << fault->what;
}

}  // namespace
}  // namespace tandem
