#include "engine/paging/slow_pages.h"

#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "engine/realtime/clock.h"
#include "engine/voxel/build/voxelize.h"
#include "tests/support/delayed_pages.h"
#include "tests/support/shapes.h"

namespace tandem {
namespace {

TEST(SlowPages, DelayIsProportionalToSize) {
  const Result<Voxmap> whole = Voxelize(testing::Sphere(0.5, 4), {.voxel_size = 0.006});
  ASSERT_TRUE(whole);
  const auto pages = std::make_shared<const testing::DelayedPages>(*whole);
  constexpr double kBytesPerSecond = 2e6;
  const SlowPages slow(pages, kBytesPerSecond);
  double bytes = 0;
  const std::int64_t begin_ns = MonotonicNowNs();
  for (std::uint32_t r = 2; r < whole->header().record_count && bytes < 2e5; ++r) {
    if (!slow.HasPage(r)) continue;
    VoxelPage page;
    VoxelPage same;
    ASSERT_FALSE(slow.Read(r, page, {}));
    ASSERT_FALSE(pages->Read(r, same, {}));
    EXPECT_EQ(page.quarters, same.quarters);
    bytes += static_cast<double>(slow.BytesOf(r));
  }
  const double seconds = ToSeconds(MonotonicNowNs() - begin_ns);
  EXPECT_GT(bytes, 1e5);
  EXPECT_GE(seconds, bytes / kBytesPerSecond);
}

}  // namespace
}  // namespace tandem
