#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/diagnostics/attack.h"
#include "collab/dds/transport/domain.h"

namespace tandem::testing {
namespace {

constexpr std::uint32_t kDomain = 113;  // no other test's

/// A socket where a program of the domain with that number listens for others.
class ListeningPort {
 public:
  explicit ListeningPort(std::uint32_t program)
      : descriptor_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in own{};
    own.sin_family = AF_INET;
    own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    own.sin_port = htons(static_cast<std::uint16_t>(DiscoveryPort(kDomain, program)));
    is_bound_ = bind(descriptor_, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0;
  }
  ListeningPort(ListeningPort&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)), is_bound_(other.is_bound_) {}
  ListeningPort(const ListeningPort&) = delete;
  ListeningPort& operator=(const ListeningPort&) = delete;
  ~ListeningPort() {
    if (descriptor_ >= 0) close(descriptor_);
  }

  bool is_bound() const { return is_bound_; }
  /// Returns how many announcements came. A probe of one byte is none.
  int Announcements() const {
    std::array<char, 2048> packet{};
    int count = 0;
    for (ssize_t size = 0; size >= 0;) {
      size = recv(descriptor_, packet.data(), packet.size(), MSG_DONTWAIT);
      count += size > 20 ? 1 : 0;
    }
    return count;
  }

 private:
  int descriptor_;
  bool is_bound_;
};

TEST(Flood, ReachesEveryProgramOfTheDomain) {
  std::vector<ListeningPort> ports;
  for (std::uint32_t program = 0; program < 8; ++program) {
    ports.emplace_back(program);
    ASSERT_TRUE(ports.back().is_bound());
  }
  DdsOptions options;
  options.session = "floods";
  options.domain = kDomain;
  options.interface = "lo";
  options.peer = 7;
  const Result<std::uint64_t> sent =
      Flood(tandem::Attack::kPackets, options, {.seconds = 5, .most = 320});
  ASSERT_TRUE(sent) << sent.error().what;
  for (const ListeningPort& port : ports) EXPECT_GT(port.Announcements(), 0);
}

}  // namespace
}  // namespace tandem::testing
