#include "engine/paging/resident_voxels.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "engine/voxel/build/voxelize.h"
#include "tests/support/delayed_pages.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

using testing::DelayedPages;

constexpr double kVoxel = 0.001;
constexpr double kMiddle = 0.032;  // middle of a row of hyperchunks

/// A long bar along x with a ball that says where one looks.
class ResidentVoxelsTest : public ::testing::Test {
 protected:
  ResidentVoxelsTest() {
    const Result<Voxmap> whole =
        Voxelize(testing::At(testing::Box(Vec3(20.0, 0.02, 0.02)), Vec3(0, kMiddle, kMiddle)),
                 {.voxel_size = kVoxel});
    TANDEM_CHECK(whole);
    pages_ = std::make_shared<DelayedPages>(*whole);
    const std::uint64_t budget = VoxelArena::FixedBytes(whole_outline()) + (1U << 20U);
    auto made = ResidentVoxels::Make(pages_, budget);
    TANDEM_CHECK(made);
    voxels_ = std::move(*made);
    reader_ = &voxels_->AddReader(Vec3::Zero(), Vec3::Constant(0.005));
    wide_ = &voxels_->AddReader(Vec3::Zero(), Vec3::Constant(20));
    wide_->Leave();
    voxels_->Start();
  }

  const Voxmap& whole_outline() const { return pages_->outline(); }
  /// Returns where on the bar something is, in voxels of V.
  Vec3 At(double x) const { return (Vec3(x, kMiddle, kMiddle) - whole_outline().p_WVo()) / kVoxel; }
  std::uint32_t RecordAt(double x) const {
    const auto& size = whole_outline().header().size;
    const Vec3 p = At(x) / kHyperchunkSide;
    const auto index = [&p](int axis) {
      return static_cast<std::size_t>(std::floor(p[axis]));
    };
    return whole_outline().index()[index(0) + size[0] * (index(1) + size[1] * index(2))];
  }
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

  std::shared_ptr<DelayedPages> pages_;
  std::unique_ptr<ResidentVoxels> voxels_;
  VoxelReader* reader_ = nullptr;
  VoxelReader* wide_ = nullptr;  // its shell is as long as the bar, and not tested at first
  double at_ = 0;
};

TEST_F(ResidentVoxelsTest, AnnouncedPagesAreLoaded) {
  Go(-9.9);
  EXPECT_FALSE(Announce());
  voxels_->WaitUntilResident();
  EXPECT_TRUE(Announce());
  // free space has no pages
  EXPECT_TRUE(reader_->Announce(At(-9.9) + Vec3(0, 500, 0), 20, 0));
}

TEST_F(ResidentVoxelsTest, PagesInUseAreNeverEvicted) {
  Go(0);
  Announce();
  voxels_->WaitUntilResident();
  ASSERT_TRUE(Announce());
  // hints all along the bar, many more than there is room for
  for (int round = 0; round < 3; ++round) {
    for (double x = -9.9; x < 9.9; x += 0.05) {
      reader_->Hint(At(x), 10, 0);
      voxels_->BeginFrame();
    }
    voxels_->WaitUntilResident();
    EXPECT_TRUE(Announce()) << round;
  }
}

TEST_F(ResidentVoxelsTest, ReadablePagesAreNeverEvicted) {
  Go(0);
  std::vector<double> there;
  for (int round = 0; round < 4; ++round) {
    for (const double x : there) EXPECT_TRUE(reader_->Announce(At(x), 10, 0)) << x;
    there.clear();
    for (double x = -9.9; x < 9.9; x += 0.1) {
      if (reader_->Announce(At(x), 10, 0)) there.push_back(x);
    }
    voxels_->WaitUntilResident();
  }
  EXPECT_GT(there.size(), 3U);
  EXPECT_LT(there.size(), 190U) << "all of them have room";
}

TEST_F(ResidentVoxelsTest, AnnouncementMakesAHintUrgent) {
  Go(-9.9);
  pages_->Close();
  pages_->Take(std::chrono::milliseconds(5));
  constexpr double kPage = 0.064;
  for (int page = 0; page < 20; ++page) reader_->Hint(At(-9.9 + page * kPage), 2, 0);
  const double last = -9.9 + 19 * kPage;
  for (int frame = 0; frame < 3000; ++frame) voxels_->BeginFrame();
  ASSERT_FALSE(reader_->Announce(At(last), 2, 0));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // it is heard of
  pages_->Open();
  for (int k = 0; k < 4000 && !reader_->Announce(At(last), 2, 0); ++k) {
    voxels_->BeginFrame();
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  EXPECT_TRUE(reader_->Announce(At(last), 2, 0));
  const std::vector<std::uint32_t> order = pages_->order();
  const auto at = std::find(order.begin(), order.end(), RecordAt(last)) - order.begin();
  EXPECT_LE(at, 1) << "more came before it than the one that was under way";
}

TEST_F(ResidentVoxelsTest, IdleReaderKeepsNoPages) {
  wide_->MoveTo({}, 0);
  for (double x = -9.9; x < 9.9; x += 0.05) wide_->Announce(At(x), 10, 0);
  voxels_->WaitUntilResident();
  Go(9.8);
  Announce();
  voxels_->WaitUntilResident();
  ASSERT_FALSE(Announce()) << "there is room for all";
  EXPECT_TRUE(wide_->Leave());
  EXPECT_TRUE(ComesSoon());
}

TEST_F(ResidentVoxelsTest, FindsEvictablePagesAmongPinnedOnes) {
  // all are as near to a shell as long as the bar
  reader_->Leave();
  wide_->MoveTo({}, 0);
  for (double x = -9.9; x < 9.9; x += 0.05) wide_->Announce(At(x), 10, 0);
  voxels_->WaitUntilResident();
  std::vector<double> there;
  for (double x = -9.9; x < 9.9; x += 0.05) {
    if (wide_->Announce(At(x), 10, 0)) there.push_back(x);
  }
  ASSERT_GT(there.size(), 10U);
  wide_->MoveTo({}, 2 * VoxelReader::kKeptTravel);
  // one of them, whichever is asked back first, may go
  const double goes = there[there.size() / 2];
  double lacks = 9.8;
  while (wide_->Announce(At(lacks), 10, 0)) lacks -= 0.05;
  bool came = false;
  for (int k = 0; k < 4000 && !came; ++k) {
    for (const double x : there) {
      if (std::abs(x - goes) > 0.2) wide_->Announce(At(x), 10, 0);
    }
    came = wide_->Announce(At(lacks), 10, 0);
    voxels_->BeginFrame();
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  EXPECT_TRUE(came);
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

TEST_F(ResidentVoxelsTest, ReportsWhyPagesAreMissing) {
  pages_->Break();
  Go(1);
  EXPECT_FALSE(Announce());
  voxels_->WaitUntilResident();
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
