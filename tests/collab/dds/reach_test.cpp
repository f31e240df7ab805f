#include "collab/dds/reach.h"

#include <atomic>
#include <thread>

#include <gmock/gmock.h>

#include "collab/dds/cyclone_log.h"
#include "tests/collab/dds/live_peer.h"

namespace tandem {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

TEST(Reach, TheLoopbackIsAmongTheInterfaces) {
  const std::vector<InterfaceFacts> all = UsableInterfaces();
  const auto lo = std::find_if(all.begin(), all.end(), [](const InterfaceFacts& one) {
    return one.name == "lo";
  });
  ASSERT_NE(lo, all.end());
  EXPECT_EQ(lo->address, "127.0.0.1");
  EXPECT_TRUE(lo->loopback);
  EXPECT_GE(lo->mtu, 1500);
}

TEST(Reach, AnswersTellThePathsSizeAndRoundTrip) {
  Result<ProbeAnswerer> answerer = ProbeAnswerer::Open(0);
  ASSERT_TRUE(answerer.has_value()) << answerer.error().what;
  std::atomic<bool> stop{false};
  std::thread answering([&] {
    while (!stop) answerer->Answer(10);
  });
  const PathFacts path = ProbePath("127.0.0.1", answerer->port());
  stop = true;
  answering.join();
  EXPECT_EQ(path.error, "");
  EXPECT_EQ(path.address, "127.0.0.1");
  EXPECT_EQ(path.answered, path.sent);
  EXPECT_EQ(path.largest_answered, 1472);
  EXPECT_GT(path.least_round_trip_ms, 0.0);
  EXPECT_GE(path.route_mtu, 1500);
}

TEST(Reach, AMachineWithoutAnAnswererIsToldFromOneThatIsNotThere) {
  const PathFacts path = ProbePath("127.0.0.1", testing::FreePortPair());
  EXPECT_TRUE(path.refused);
  EXPECT_EQ(path.answered, 0);
  EXPECT_THAT(ProbePath("no-such-host.invalid", 7400).error, HasSubstr("no IPv4 address"));
}

TEST(Reach, APortInUseIsSeen) {
  constexpr std::uint32_t kDomain = 97;
  const auto port = static_cast<std::uint16_t>(DiscoveryPort(kDomain, 1));
  const Result<ProbeAnswerer> other = ProbeAnswerer::Open(port);
  ASSERT_TRUE(other.has_value()) << other.error().what;
  EXPECT_THAT(PortsTaken(kDomain, 4), Contains(port));
  EXPECT_FALSE(ProbeAnswerer::Open(port).has_value());
}

TEST(Reach, CyclonesWordsComeWithOurs) {
  EXPECT_THAT(InPlainWords("Begin handshake reply failed: Certificate not valid: error: x"),
              HasSubstr("somebody with keys of another session was refused"));
  const std::string unknown = InPlainWords("ddsi_frobnicate: 0x17");
  EXPECT_THAT(unknown, HasSubstr("the network layer says"));
  EXPECT_THAT(unknown, HasSubstr("ddsi_frobnicate: 0x17"));
}

}  // namespace
}  // namespace tandem
