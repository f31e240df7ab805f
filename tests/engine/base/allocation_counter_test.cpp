#include "tests/support/allocation_counter.h"

#include <cstdlib>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

namespace tandem::testing {
namespace {

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

struct alignas(64) CacheLine {
  char bytes[64];  // NOLINT(modernize-avoid-c-arrays)
};

TEST(AllocationCounter, CountsEveryKindOfAllocationDuringItsLifetime) {
  const std::vector<int> before(100);
  long counted = 0;
  {
    const AllocationCounter allocations;
    std::vector<int> copy = before;
    EXPECT_EQ(allocations.count(), 1);
    copy.resize(200);
    EXPECT_EQ(allocations.count(), 2);
    const auto line = std::make_unique<CacheLine>();
    EXPECT_EQ(allocations.count(), 3);
    void* block = std::calloc(3, 5);
    block = std::realloc(block, 500);
    std::free(block);
    counted = allocations.count();
  }
  EXPECT_EQ(counted, 5);
  auto after = std::make_unique<int>(1);
  EXPECT_NE(after, nullptr);
  const AllocationCounter allocations;
  EXPECT_EQ(allocations.count(), 0);
}

#endif

}  // namespace
}  // namespace tandem::testing
