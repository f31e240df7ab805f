#include "collab/dds/diagnostics/reachability.h"

#include <array>
#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/cyclone/cyclone_log.h"
#include "collab/dds/cyclone/socket_drops.h"
#include "tests/collab/dds/live_peer.h"

namespace tandem {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Reachability, TheLoopbackIsAmongTheInterfaces) {
  const std::vector<InterfaceFacts> all = UsableInterfaces();
  const auto lo = std::find_if(all.begin(), all.end(), [](const InterfaceFacts& one) {
    return one.name == "lo";
  });
  ASSERT_NE(lo, all.end());
  EXPECT_EQ(lo->address, "127.0.0.1");
  EXPECT_TRUE(lo->loopback);
  EXPECT_GE(lo->mtu, 1500);
}

TEST(Reachability, AnswersReportPathMtuAndRoundTrip) {
  Result<ProbeResponder> responder = ProbeResponder::Open(0);
  ASSERT_TRUE(responder.has_value()) << responder.error().what;
  std::atomic<bool> stop{false};
  std::thread answering([&] {
    while (!stop) responder->Answer(10);
  });
  const PathFacts path = ProbePath("127.0.0.1", responder->port());
  stop = true;
  answering.join();
  EXPECT_EQ(path.error, "");
  EXPECT_EQ(path.address, "127.0.0.1");
  EXPECT_EQ(path.answered, path.sent);
  EXPECT_EQ(path.largest_answered, 1472);
  EXPECT_GT(path.least_round_trip_ms, 0.0);
  EXPECT_GE(path.route_mtu, 1500);
}

TEST(Reachability, SocketOverflowIsCounted) {
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

/// A socket that sends what it likes.
class OwnSocket {
 public:
  OwnSocket() : handle_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in own = To(0);
    bind(handle_, reinterpret_cast<const sockaddr*>(&own), sizeof own);
  }
  ~OwnSocket() { close(handle_); }
  OwnSocket(const OwnSocket&) = delete;
  OwnSocket& operator=(const OwnSocket&) = delete;

  void Send(const std::string& packet, std::uint16_t port) const {
    const sockaddr_in to = To(port);
    sendto(handle_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to),
           sizeof to);
  }
  /// Returns the packets that wait.
  std::vector<std::string> Received() const {
    std::vector<std::string> all;
    std::array<char, 2048> got{};
    for (ssize_t size = 0; (size = recv(handle_, got.data(), got.size(), MSG_DONTWAIT)) > 0;) {
      all.emplace_back(got.data(), static_cast<std::size_t>(size));
    }
    return all;
  }

 private:
  static sockaddr_in To(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return address;
  }

  int handle_;
};

// byte for byte what the product sends: a mark of eight letters, then eight bytes of time
const std::string kForgedProbe = std::string("td-probe") + std::string(56, 'x');

TEST(Reachability, AnswersAreNotProbes) {
  Result<ProbeResponder> responder = ProbeResponder::Open(0);
  ASSERT_TRUE(responder.has_value()) << responder.error().what;
  const OwnSocket asking;
  asking.Send(kForgedProbe, responder->port());
  EXPECT_EQ(responder->Answer(50), 1);
  const std::vector<std::string> answers = asking.Received();
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(answers[0].size(), kForgedProbe.size());
  // the answer itself, as if it came from another responder
  asking.Send(answers[0], responder->port());
  EXPECT_EQ(responder->Answer(50), 0);
  EXPECT_TRUE(asking.Received().empty());
}

TEST(Reachability, ResponderIgnoresItsOwnPort) {
  Result<ProbeResponder> responder = ProbeResponder::Open(0);
  ASSERT_TRUE(responder.has_value()) << responder.error().what;
  // a raw socket writes the source's port itself
  const int raw = socket(AF_INET, SOCK_RAW, IPPROTO_UDP);
  if (raw < 0) GTEST_SKIP() << "raw sockets are refused here";
  const std::uint16_t port = htons(responder->port());
  const auto length = static_cast<std::uint16_t>(8 + kForgedProbe.size());
  const std::array<std::uint16_t, 4> header{port, port, htons(length), 0};
  std::string packet(reinterpret_cast<const char*>(header.data()), sizeof header);
  packet += kForgedProbe;
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(sendto(raw, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to),
                   sizeof to),
            static_cast<ssize_t>(packet.size()));
  close(raw);
  EXPECT_EQ(responder->Answer(50), 0);
}

TEST(Reachability, ProbeFloodIsAnsweredAtABoundedRate) {
  Result<ProbeResponder> responder = ProbeResponder::Open(0);
  ASSERT_TRUE(responder.has_value()) << responder.error().what;
  const OwnSocket flood;
  std::atomic<bool> stop{false};
  std::atomic<long> sent{0};
  std::thread flooding([&] {
    while (!stop) {
      flood.Send(kForgedProbe, responder->port());
      ++sent;
    }
  });
  const auto began = std::chrono::steady_clock::now();
  int answered = 0;
  for (int i = 0; i < 5; ++i) answered += responder->Answer(100);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  stop = true;
  flooding.join();
  EXPECT_GT(sent, 2 * ProbeResponder::kMostAnswersPerSecond);
  EXPECT_GT(answered, 0);
  // in one second, or in the two that the calls are in
  EXPECT_LE(answered, 2 * ProbeResponder::kMostAnswersPerSecond);
  EXPECT_LT(took.count(), 2.0);
}

TEST(Reachability, MissingResponderDiffersFromAMissingHost) {
  const PathFacts path = ProbePath("127.0.0.1", testing::FreePortPair());
  EXPECT_TRUE(path.refused);
  EXPECT_EQ(path.answered, 0);
  EXPECT_THAT(ProbePath("no-such-host.invalid", 7400).error, HasSubstr("no IPv4 address"));
}

TEST(Reachability, PortInUseIsDetected) {
  constexpr std::uint32_t kDomain = 97;
  const auto port = static_cast<std::uint16_t>(DiscoveryPort(kDomain, 1));
  const Result<ProbeResponder> other = ProbeResponder::Open(port);
  ASSERT_TRUE(other.has_value()) << other.error().what;
  EXPECT_THAT(PortsTaken(kDomain, 4), Contains(port));
  EXPECT_FALSE(ProbeResponder::Open(port).has_value());
}

TEST(Reachability, CycloneMessagesAreIncluded) {
  EXPECT_THAT(ExplainMessage("Begin handshake reply failed: Certificate not valid: error: x"),
              HasSubstr("somebody with keys of another session was refused"));
  const std::string unknown = ExplainMessage("ddsi_frobnicate: 0x17");
  EXPECT_THAT(unknown, HasSubstr("tandem doctor"));
  EXPECT_THAT(unknown, Not(HasSubstr("frobnicate")));
}

}  // namespace
}  // namespace tandem
