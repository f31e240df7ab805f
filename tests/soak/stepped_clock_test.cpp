#include <chrono>
#include <ctime>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "tests/network/running_program.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {
namespace {

TEST(SteppedClock, OnlyTheProgramSeesTheClockStep) {
#ifndef TANDEM_STEPPED_CLOCK
  GTEST_SKIP() << "a sanitizer's own library must be loaded first";
#else
  constexpr std::int64_t kHour = 3600;
  const ScratchFolder folder;
  const std::int64_t step_ns = -1'000'000'000 * kHour;
  const std::filesystem::path clock = folder.path() / "clock";
  std::ofstream(clock, std::ios::binary)
      .write(reinterpret_cast<const char*>(&step_ns), sizeof step_ns);
  const std::int64_t before = std::time(nullptr);
  Program date({"/usr/bin/env", "LD_PRELOAD=" TANDEM_STEPPED_CLOCK,
                "STEPPED_CLOCK=" + clock.string(), "/bin/date", "+%s"},
               folder.path() / "said");
  ASSERT_EQ(date.Wait(), 0);
  const std::int64_t seen = std::stoll(date.output());
  EXPECT_GE(seen, before - kHour);
  // time() reads a clock that is some milliseconds late, date one that is not
  const auto now = std::chrono::system_clock::now();
  EXPECT_LE(seen, std::chrono::system_clock::to_time_t(now) - kHour);
#endif
}

}  // namespace
}  // namespace tandem::testing
