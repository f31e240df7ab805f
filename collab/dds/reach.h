#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <netinet/in.h>

#include "collab/dds/domain.h"
#include "collab/dds/line_answerer.h"

namespace tandem {

/// A network interface that is up and has an IPv4 address.
struct InterfaceFacts {
  std::string name;
  std::string address;
  int mtu = 0;  // bytes
  bool loopback = false;
  bool multicast = false;  // by its flags
};
std::vector<InterfaceFacts> UsableInterfaces();

/// The interface to use: the one asked for; the loopback's where nothing else is up and nobody
/// elsewhere is named; else empty, for DDS to choose. Without it DDS would look for multicast on
/// loopback, and warn that there is none.
std::string InterfaceFor(const DdsOptions& options, const std::vector<InterfaceFacts>& usable);

/// Whether a packet sent to DDS's discovery group by this interface comes back to a listener on it.
bool MulticastWorks(const InterfaceFacts& interface);

/// UDP ports of a domain on this machine that other programs have, among those of the first `count`
/// participants.
std::vector<std::uint16_t> PortsTaken(std::uint32_t domain, std::uint32_t count);

/// What is known of the way to another machine.
struct PathFacts {
  std::string error;     // why nothing can be sent at all; else empty
  std::string address;   // what the host's name stands for
  int route_mtu = 0;     // bytes, of the IP packet, that the kernel believes in
  bool refused = false;  // the machine is there and says that nobody listens at that port
  int answered = 0;      // probes that came back, of `sent`
  int sent = 0;
  int largest_answered = 0;  // bytes of UDP payload, unfragmented
  double least_round_trip_ms = 0;
};

/// Sends unfragmentable packets of growing size, several each, to a ProbeAnswerer there.
PathFacts ProbePath(const std::string& host, std::uint16_t port);

/// Answers probes where they came from: no answer of another, nothing from the port that answerers
/// have, and not more than kMostAnswersPerSecond. With those that asked for it and were found to be
/// at their address, it records a line (LineAnswerer).
class ProbeAnswerer {
 public:
  static constexpr int kMostAnswersPerSecond = 200;

  /// Port 0: any. Errors: the port is taken.
  static Result<ProbeAnswerer> Open(std::uint16_t port);
  ProbeAnswerer(ProbeAnswerer&& other) noexcept;
  ProbeAnswerer& operator=(ProbeAnswerer&&) = delete;
  ~ProbeAnswerer();
  std::uint16_t port() const noexcept { return port_; }
  /// Answers what comes within `wait_ms`, and returns then; how many.
  int Answer(int wait_ms);

 private:
  ProbeAnswerer(int socket, std::uint16_t port);
  bool MayAnswer(std::int64_t now_ns);
  void SendSamples();
  /// Returns whether it was a probe, and was answered.
  bool AnswerPacket(std::span<std::byte> packet, const sockaddr_in& from, std::int64_t arrival_ns);

  int socket_;
  std::uint16_t port_;
  std::int64_t second_ns_ = 0;
  int answered_in_second_ = 0;
  LineAnswerer lines_;
};

}  // namespace tandem
