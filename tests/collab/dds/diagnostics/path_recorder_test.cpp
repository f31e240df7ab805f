#include "collab/dds/diagnostics/path_recorder.h"

#include <atomic>
#include <vector>

#include <gmock/gmock.h>

#include "engine/base/units.h"
#include "tests/collab/dds/diagnostics/line_relay.h"
#include "tests/collab/dds/live_peer.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

bool LostThere(std::uint32_t seq) {
  return seq % 10 == 3 || (seq >= 200 && seq < 240);
}
bool LostBack(std::uint32_t seq) {
  return seq % 7 == 5;
}

TEST(PathRecorder, LossIsExactAndDelaysAreNotTooShort) {
  const testing::Answering answering;
  const testing::Relay relay(
      testing::AddressOf("127.0.0.1", answering.port()),
      [](std::uint32_t seq) {
        if (LostThere(seq)) return std::vector<std::int64_t>{};
        // one in fifty is held back for so long that hundreds overtake it
        return std::vector<std::int64_t>{(seq % 50 == 10 ? 620 : 20) * kMs};
      },
      [](std::uint32_t seq) {
        if (LostBack(seq)) return std::vector<std::int64_t>{};
        if (seq % 100 == 1) return std::vector<std::int64_t>{30 * kMs, 33 * kMs};
        return std::vector<std::int64_t>{30 * kMs};
      });
  const std::atomic<bool> stop{false};
  const Result<RecordedPath> line =
      RecordPath("127.0.0.1", relay.port(), {.rate_hz = 500, .samples = 500, .bytes = 300}, stop);
  ASSERT_TRUE(line) << line.error().what;
  ASSERT_EQ(line->record.there_ns.size(), 500U);
  int late = 0;
  for (std::uint32_t seq = 0; seq < 500; ++seq) {
    SCOPED_TRACE(seq);
    const std::int64_t there = line->record.there_ns[seq];
    const std::int64_t back = line->record.back_ns[seq];
    EXPECT_EQ(there == PathRecord::kNever, LostThere(seq));
    EXPECT_EQ(back == PathRecord::kNever, LostBack(seq));
    // both ends have one clock, so the noted difference is the delay
    if (!LostThere(seq)) {
      EXPECT_GE(there, (seq % 50 == 10 ? 620 : 20) * kMs);
    }
    if (!LostBack(seq)) {
      EXPECT_GE(back, 30 * kMs);
    }
    late += there > 600 * kMs ? 1 : 0;
  }
  EXPECT_GE(late, 9);
  EXPECT_EQ(line->twice, 4U);  // 1, 101, 301 and 401; 201 is lost
  ASSERT_FALSE(line->loop_age_ns.empty());
  for (std::size_t i = 0; i < line->loop_age_ns.size(); ++i) {
    EXPECT_GE(line->held_ns[i], 0);
    EXPECT_GE(line->loop_age_ns[i] - line->held_ns[i], 50 * kMs);
  }
}

TEST(PathRecorder, ReportsSilentHostsAndStopsOnRequest) {
  std::atomic<bool> stop{true};
  EXPECT_FALSE(RecordPath("127.0.0.1", testing::FreePortPair(), {.samples = 10}, stop));
  stop = false;
  EXPECT_THAT(RecordPath("no-such-host.invalid", 7399, {.samples = 10}, stop).error().what,
              HasSubstr("no IPv4 address"));
  EXPECT_FALSE(RecordPath("127.0.0.1", 7399, {.rate_hz = 5000}, stop));
}

}  // namespace
}  // namespace tandem
