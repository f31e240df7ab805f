#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include "app/stability/live/tap_hub.h"
#include "collab/dds/diagnostics/path_recorder.h"
#include "tests/collab/dds/diagnostics/line_relay.h"
#include "tests/support/tap_hub_here.h"

// A line between network namespaces: a requester (10.78.0.1), a relay that loses what the test
// names (10.78.0.2), a responder (10.78.0.3), and a hub that holds every frame back.
namespace tandem {
namespace {

constexpr double kHopMs = 10;

/// Runs `work` in the network that programs at that port of the hub have.
void InNetworkOf(const TapHub& hub, std::size_t port, const std::function<void()>& work) {
  // {ip, netns, exec, NAME, ...}
  const std::string file = "/var/run/netns/" + hub.At(port, {})[3];
  std::thread([&] {
    const int space = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    ASSERT_GE(space, 0) << file;
    ASSERT_EQ(setns(space, CLONE_NEWNET), 0);
    close(space);
    work();
  }).join();
}

bool Lost(std::uint32_t seq) {
  return seq % 20 == 7 || seq % 1000 / 50 == 3;  // one in twenty, and bursts of fifty
}

std::vector<std::int64_t> FateThere(std::uint32_t seq) {
  return Lost(seq) ? std::vector<std::int64_t>{} : std::vector<std::int64_t>{0};
}

std::vector<std::int64_t> FateBack(std::uint32_t seq) {
  return Lost(seq + 500) ? std::vector<std::int64_t>{} : std::vector<std::int64_t>{0};
}

TEST(LineBetweenNamespaces, LossIsExactAndRoundTripsAreNotTooShort) {
  if (const char* const why = testing::WhyNoTapHub()) GTEST_SKIP() << why;
  auto hub = TapHub::Open(3, [](std::size_t, std::size_t) {
    return LinkConditions{.delay_ms = kHopMs};
  });
  ASSERT_TRUE(hub) << hub.error().what;
  std::unique_ptr<testing::Answering> answering;
  std::unique_ptr<testing::Relay> relay;
  InNetworkOf(**hub, 2, [&] {
    answering = std::make_unique<testing::Answering>();
  });
  InNetworkOf(**hub, 1, [&] {
    relay = std::make_unique<testing::Relay>(testing::AddressOf("10.78.0.3", answering->port()),
                                             FateThere, FateBack);
  });
  Result<RecordedPath> line = Error{"none"};
  const std::atomic<bool> stop{false};
  InNetworkOf(**hub, 0, [&] {
    line = RecordPath("10.78.0.2", relay->port(), {.rate_hz = 500, .samples = 2000}, stop);
  });
  ASSERT_TRUE(line) << line.error().what;
  for (std::uint32_t seq = 0; seq < 2000; ++seq) {
    SCOPED_TRACE(seq);
    EXPECT_EQ(line->record.there_ns[seq] == PathRecord::kNever, Lost(seq));
    EXPECT_EQ(line->record.back_ns[seq] == PathRecord::kNever, Lost(seq + 500));
  }
  // Two hops there and two back, each of 10 ms. The bound is taken after the drift of the clocks,
  // which four seconds of a busy machine tell to some 25 ppm.
  const ClockEstimate clocks = EstimateClocks(line->record);
  EXPECT_GE(clocks.bound_ms, 2 * kHopMs - 0.2);
  for (std::size_t i = 0; i < line->loop_age_ns.size(); ++i) {
    EXPECT_GE(line->loop_age_ns[i] - line->held_ns[i], 4 * 1'000'000 * kHopMs);
  }
}

}  // namespace
}  // namespace tandem
