#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <netinet/in.h>

#include "collab/dds/diagnostics/path_responder.h"
#include "collab/dds/transport/domain.h"

namespace tandem {

/// A network interface that is up and has an IPv4 address. Without carrier it reaches nobody, and a
/// session passes it over.
struct InterfaceFacts {
  std::string name;
  std::string address;
  int mtu = 0;  // bytes
  bool loopback = false;
  bool multicast = false;  // its flags say so
  bool carrier = true;
};
std::vector<InterfaceFacts> UsableInterfaces();

/// Returns whether a packet that this interface sends to DDS's discovery group comes back to a
/// listener on it.
bool MulticastWorks(const InterfaceFacts& interface);

/// Returns the UDP ports of a domain on this machine that other programs have, among those of the
/// first `count` participants.
std::vector<std::uint16_t> PortsTaken(std::uint32_t domain, std::uint32_t count);

/// The measured path to another machine.
struct PathFacts {
  std::string error;      // reason why nothing can be sent at all; else empty
  std::string address;    // address of the host's name
  std::string interface;  // the interface that the route to it takes
  int route_mtu = 0;      // bytes of the IP packet, as the kernel knows it
  bool refused = false;   // the machine answers that no program listens at that port
  int answered = 0;       // number of probes that came back, out of `sent`
  int sent = 0;
  int largest_answered = 0;  // bytes of UDP payload, unfragmented
  double least_round_trip_ms = 0;
};

/// Sends unfragmentable packets of growing size, several of each, to a ProbeResponder there.
/// `interface`: the only one that the session uses; empty: the route decides, as in a session.
PathFacts ProbePath(const std::string& host, std::uint16_t port, const std::string& interface = {});

/// Answers probes, to the address that they came from. It does not answer answers, nor packets from
/// its own port number, and sends at most kMostAnswersPerSecond. It also records a line
/// (PathResponder) with a requester that has proved its address.
class ProbeResponder {
 public:
  static constexpr int kMostAnswersPerSecond = 200;

  /// Port 0: any free port. `interface`: the only one, beside this machine itself, that reaches it;
  /// empty: all. Error: the port is taken.
  static Result<ProbeResponder> Open(std::uint16_t port, const std::string& interface = {});
  ProbeResponder(ProbeResponder&& other) noexcept;
  ProbeResponder& operator=(ProbeResponder&&) = delete;
  ~ProbeResponder();
  std::uint16_t port() const noexcept { return port_; }
  /// Answers the packets that come within `wait_ms`, and returns how many probes it answered.
  int Answer(int wait_ms);

 private:
  ProbeResponder(int socket, std::uint16_t port);
  bool MayAnswer(std::int64_t now_ns);
  void SendSamples();
  /// Returns whether the packet was a probe that was answered.
  bool AnswerPacket(std::span<std::byte> packet, const sockaddr_in& from, std::int64_t arrival_ns);

  int socket_;
  std::uint16_t port_;
  std::int64_t second_ns_ = 0;
  int answered_in_second_ = 0;
  PathResponder lines_;
};

}  // namespace tandem
