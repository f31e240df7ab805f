#include "collab/dds/diagnostics/reachability.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <random>
#include <span>
#include <utility>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/diagnostics/udp_stamps.h"
#include "collab/dds/networks/usable_networks.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr const char* kDiscoveryGroup = "239.255.0.1";
constexpr std::array<char, 8> kProbeMark{'t', 'd', '-', 'p', 'r', 'o', 'b', 'e'};
// differs from a probe's mark, so that nobody answers an answer
constexpr std::array<char, 8> kAnswerMark{'t', 'd', '-', 'a', 'n', 's', 'w', 'r'};
constexpr std::array<int, 5> kProbeSizes{64, 512, 1200, 1400, 1472};  // bytes of payload
constexpr int kProbesOfASize = 3;
constexpr int kProbeWaitMs = 400;

struct Probe {
  std::array<char, 8> mark = kProbeMark;
  std::int64_t sent_ns = 0;
};

class Socket {
 public:
  Socket() : handle_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~Socket() {
    if (handle_ >= 0) close(handle_);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  int get() const { return handle_; }
  bool Set(int level, int option, int value) const {
    return setsockopt(handle_, level, option, &value, sizeof value) == 0;
  }
  int Release() { return std::exchange(handle_, -1); }

 private:
  int handle_;
};

sockaddr_in Address(in_addr host, std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr = host;
  address.sin_port = htons(port);
  return address;
}

in_addr Parse(const std::string& text) {
  in_addr address{};
  inet_pton(AF_INET, text.c_str(), &address);
  return address;
}

std::string Text(in_addr address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  inet_ntop(AF_INET, &address, text.data(), text.size());
  return text.data();
}

bool Bind(const Socket& socket, in_addr host, std::uint16_t port) {
  const sockaddr_in address = Address(host, port);
  return bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

std::uint16_t PortOf(const Socket& socket) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

bool Readable(int handle, int wait_ms) {
  pollfd wait{handle, POLLIN, 0};
  return poll(&wait, 1, wait_ms) > 0;
}

std::optional<in_addr> Resolve(const std::string& host) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) return std::nullopt;
  const in_addr address = reinterpret_cast<const sockaddr_in*>(found->ai_addr)->sin_addr;
  freeaddrinfo(found);
  return address;
}

void SendTo(int handle, const sockaddr_in& to, std::span<const std::byte> packet) {
  sendto(handle, packet.data(), packet.size(), MSG_DONTWAIT, reinterpret_cast<const sockaddr*>(&to),
         sizeof to);
}

std::array<std::uint8_t, 32> RandomSecret() {
  std::random_device random;
  std::array<std::uint8_t, 32> secret;
  for (std::uint8_t& byte : secret) byte = static_cast<std::uint8_t>(random());
  return secret;
}

// Returns the name of the interface that has the socket's own address.
std::string InterfaceOf(const Socket& socket) {
  sockaddr_in own{};
  socklen_t size = sizeof own;
  getsockname(socket.get(), reinterpret_cast<sockaddr*>(&own), &size);
  for (const NetworkAddress& one : UsableNetworks()) {
    if (one.address == own.sin_addr.s_addr) return one.name;
  }
  return {};
}

int RouteMtu(const Socket& socket) {
  int mtu = 0;
  socklen_t size = sizeof mtu;
  return getsockopt(socket.get(), IPPROTO_IP, IP_MTU, &mtu, &size) == 0 ? mtu : 0;
}

// Sends one probe and adds its result to `facts`.
void ProbeOnce(const Socket& socket, int size, PathFacts& facts) {
  std::array<std::byte, 2048> packet{};
  Probe probe;
  probe.sent_ns = MonotonicNowNs();
  std::memcpy(packet.data(), &probe, sizeof probe);
  ++facts.sent;
  if (send(socket.get(), packet.data(), static_cast<std::size_t>(size), 0) != size) {
    facts.refused = facts.refused || errno == ECONNREFUSED;
    return;  // too long for the path, as far as the kernel knows
  }
  const std::int64_t until_ns = probe.sent_ns + std::int64_t{kProbeWaitMs} * 1'000'000;
  for (std::int64_t now_ns = probe.sent_ns; now_ns < until_ns; now_ns = MonotonicNowNs()) {
    if (!Readable(socket.get(), static_cast<int>((until_ns - now_ns) / 1'000'000) + 1)) continue;
    const ssize_t got = recv(socket.get(), packet.data(), packet.size(), 0);
    if (got < 0) {
      facts.refused = facts.refused || errno == ECONNREFUSED;
      return;
    }
    Probe answer;
    std::memcpy(&answer, packet.data(), sizeof answer);
    if (got != size || answer.mark != kAnswerMark || answer.sent_ns != probe.sent_ns) continue;
    const double round_trip_ms = static_cast<double>(MonotonicNowNs() - answer.sent_ns) * 1e-6;
    facts.least_round_trip_ms =
        facts.answered == 0 ? round_trip_ms : std::min(facts.least_round_trip_ms, round_trip_ms);
    ++facts.answered;
    facts.largest_answered = std::max(facts.largest_answered, size);
    return;
  }
}

}  // namespace

std::vector<InterfaceFacts> UsableInterfaces() {
  std::vector<InterfaceFacts> found;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return found;
  const Socket socket;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_INET) continue;
    if ((i->ifa_flags & IFF_UP) == 0) continue;
    ifreq request{};
    std::strncpy(request.ifr_name, i->ifa_name, IFNAMSIZ - 1);
    const bool has_mtu = ioctl(socket.get(), SIOCGIFMTU, &request) == 0;
    found.push_back({.name = i->ifa_name,
                     .address = Text(reinterpret_cast<const sockaddr_in*>(i->ifa_addr)->sin_addr),
                     .mtu = has_mtu ? request.ifr_mtu : 0,
                     .loopback = (i->ifa_flags & IFF_LOOPBACK) != 0,
                     .multicast = (i->ifa_flags & IFF_MULTICAST) != 0,
                     .carrier = (i->ifa_flags & (IFF_LOOPBACK | IFF_RUNNING)) != 0});
  }
  freeifaddrs(list);
  return found;
}

bool MulticastWorks(const InterfaceFacts& interface) {
  const Socket listener;
  const Socket sender;
  const in_addr local = Parse(interface.address);
  ip_mreq membership{Parse(kDiscoveryGroup), local};
  // on a port of our own, other traffic of the group does not come
  if (!Bind(listener, in_addr{INADDR_ANY}, 0) ||
      setsockopt(listener.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof membership) !=
          0 ||
      setsockopt(sender.get(), IPPROTO_IP, IP_MULTICAST_IF, &local, sizeof local) != 0 ||
      !sender.Set(IPPROTO_IP, IP_MULTICAST_LOOP, 1)) {
    return false;
  }
  const sockaddr_in group = Address(Parse(kDiscoveryGroup), PortOf(listener));
  if (sendto(sender.get(), kProbeMark.data(), kProbeMark.size(), 0,
             reinterpret_cast<const sockaddr*>(&group), sizeof group) < 0) {
    return false;
  }
  return Readable(listener.get(), kProbeWaitMs);
}

std::vector<std::uint16_t> PortsTaken(std::uint32_t domain, std::uint32_t count) {
  std::vector<std::uint16_t> taken;
  for (std::uint32_t index = 0; index < count; ++index) {
    const std::uint32_t port = DiscoveryPort(domain, index);
    for (const std::uint32_t one : {port, port + 1}) {
      const Socket probe;
      if (!Bind(probe, in_addr{INADDR_ANY}, static_cast<std::uint16_t>(one))) {
        taken.push_back(static_cast<std::uint16_t>(one));
      }
    }
  }
  return taken;
}

PathFacts ProbePath(const std::string& host, std::uint16_t port, const std::string& interface) {
  PathFacts facts;
  const std::optional<in_addr> address = Resolve(host);
  if (!address) {
    facts.error = "no IPv4 address is known for that name";
    return facts;
  }
  facts.address = Text(*address);
  const Socket socket;
  const sockaddr_in to = Address(*address, port);
  socket.Set(IPPROTO_IP, IP_MTU_DISCOVER, IP_PMTUDISC_DO);
  if ((!interface.empty() && !BindToInterface(socket.get(), interface, 0)) ||
      connect(socket.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
    facts.error = std::strerror(errno);
    return facts;
  }
  facts.interface = InterfaceOf(socket);
  for (const int size : kProbeSizes) {
    const int before = facts.answered;
    for (int i = 0; i < kProbesOfASize; ++i) {
      ProbeOnce(socket, size, facts);
      if (facts.refused) break;
    }
    // a larger size will not do better
    if (facts.refused || facts.answered == before) break;
  }
  facts.route_mtu = RouteMtu(socket);
  return facts;
}

Result<ProbeResponder> ProbeResponder::Open(std::uint16_t port, const std::string& interface) {
  Socket socket;
  if (!BindToInterface(socket.get(), interface, port)) {
    return Error{"UDP port " + std::to_string(port) + ": " + std::strerror(errno)};
  }
  socket.Set(IPPROTO_IP, IP_MTU_DISCOVER, IP_PMTUDISC_DO);
  StampArrivals(socket.get());
  const std::uint16_t own = PortOf(socket);
  return ProbeResponder(socket.Release(), own);
}

ProbeResponder::ProbeResponder(int socket, std::uint16_t port)
    : socket_(socket), port_(port), lines_(RandomSecret()) {}

ProbeResponder::ProbeResponder(ProbeResponder&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)),
      port_(other.port_),
      lines_(std::move(other.lines_)) {}

ProbeResponder::~ProbeResponder() {
  if (socket_ >= 0) close(socket_);
}

int ProbeResponder::Answer(int wait_ms) {
  const std::int64_t until_ns = MonotonicNowNs() + std::int64_t{wait_ms} * 1'000'000;
  int answered = 0;
  std::array<std::byte, 2048> packet{};
  constexpr int kAtOnce = 64;  // packets before samples have their turn
  // returns at that time, whatever still comes
  while (MonotonicNowNs() < until_ns) {
    int taken = 0;
    for (; taken < kAtOnce; ++taken) {
      const std::optional<StampedPacket> got = ReceiveStamped(socket_, packet);
      if (!got) break;
      answered += AnswerPacket(std::span(packet).first(got->bytes), got->from, got->arrival_ns);
    }
    // after the packets that have come: a requester is silent only if none of its packets waits
    // here
    SendSamples();
    if (taken == kAtOnce) continue;
    WaitForPacket(socket_, std::min(until_ns, lines_.NextDueNs().value_or(until_ns)));
  }
  return answered;
}

void ProbeResponder::SendSamples() {
  lines_.SendDue(MonotonicNowNs(),
                 [this](const PathResponder::Address& to, std::span<const std::byte> packet) {
                   SendTo(socket_, Address({to.host}, ntohs(to.port)), packet);
                 });
}

bool ProbeResponder::AnswerPacket(std::span<std::byte> packet, const sockaddr_in& from,
                                  std::int64_t arrival_ns) {
  // another responder never asks
  if (ntohs(from.sin_port) == port_) return false;
  const auto may_answer = [this] {
    return MayAnswer(MonotonicNowNs());
  };
  const auto send = [&](const PathResponder::Address&, std::span<const std::byte> answer) {
    SendTo(socket_, from, answer);
  };
  if (lines_.Take(packet, {from.sin_addr.s_addr, from.sin_port}, arrival_ns, may_answer, send)) {
    return false;
  }
  if (packet.size() < sizeof(Probe)) return false;
  if (std::memcmp(packet.data(), kProbeMark.data(), kProbeMark.size()) != 0) return false;
  if (!may_answer()) return false;
  // the answer is as large as the probe, so that nobody can be flooded through us
  std::memcpy(packet.data(), kAnswerMark.data(), kAnswerMark.size());
  SendTo(socket_, from, packet);
  return true;
}

bool ProbeResponder::MayAnswer(std::int64_t now_ns) {
  if (now_ns - second_ns_ >= kSecondNs) {
    second_ns_ = now_ns;
    answered_in_second_ = 0;
  }
  return answered_in_second_++ < kMostAnswersPerSecond;
}

}  // namespace tandem
