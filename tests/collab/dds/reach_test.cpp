#include "collab/dds/reach.h"

#include <array>
#include <atomic>
#include <thread>

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/cyclone_log.h"
#include "collab/dds/socket_drops.h"
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

TEST(Reach, WhereNothingButTheLoopbackIsUpItIsUsed) {
  const InterfaceFacts lo{.name = "lo", .address = "127.0.0.1", .loopback = true};
  const InterfaceFacts eth{.name = "eth0", .address = "192.0.2.2", .multicast = true};
  DdsOptions options;
  EXPECT_EQ(InterfaceFor(options, {lo}), "lo");
  EXPECT_EQ(InterfaceFor(options, {lo, eth}), "");
  EXPECT_EQ(InterfaceFor(options, {}), "");
  options.interface = "eth0";
  EXPECT_EQ(InterfaceFor(options, {lo}), "eth0");
  // others are elsewhere
  options = {};
  options.peers = {"192.0.2.7"};
  EXPECT_EQ(InterfaceFor(options, {lo}), "");
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

TEST(Reach, PacketsThatAFullSocketLosesAreCounted) {
  const int deaf = socket(AF_INET, SOCK_DGRAM, 0);
  const int out = socket(AF_INET, SOCK_DGRAM, 0);
  const int size = 4096;
  setsockopt(deaf, SOL_SOCKET, SO_RCVBUF, &size, sizeof size);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof to;
  ASSERT_EQ(bind(deaf, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  ASSERT_EQ(getsockname(deaf, reinterpret_cast<sockaddr*>(&to), &length), 0);
  const std::uint64_t before = PacketsDroppedAtSockets();
  constexpr int kSent = 500;
  const std::array<char, 200> packet{};
  for (int i = 0; i < kSent; ++i) {
    sendto(out, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }
  const std::uint64_t dropped = PacketsDroppedAtSockets() - before;
  int kept = 0;
  std::array<char, 200> got{};
  while (recv(deaf, got.data(), got.size(), MSG_DONTWAIT) > 0) ++kept;
  close(deaf);
  close(out);
  EXPECT_GT(kept, 0);
  EXPECT_LT(kept, kSent);
  EXPECT_EQ(dropped, static_cast<std::uint64_t>(kSent - kept));
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
