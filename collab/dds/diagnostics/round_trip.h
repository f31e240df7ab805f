#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "engine/base/result.h"
#include "engine/realtime/histogram.h"

namespace tandem {

/// The times of a packet to another process of this machine and back, over a plain UDP socket and
/// over DDS. DDS is used as the product uses it: one thread writes a state with its links, and the
/// receive thread takes it. In every millisecond both are sent, in alternating order, in datagrams
/// of one length. All threads run under SCHED_FIFO where that is granted.
struct RoundTrips {
  static constexpr std::size_t kDatagramBytes = 916;  // size of one sample over RTPS, UDP payload

  Histogram udp;  // ns
  Histogram dds;
  std::uint64_t udp_lost = 0;  // no answer within 20 ms
  std::uint64_t dds_lost = 0;
  bool fifo = false;
};

struct RoundTripOptions {
  std::string session;  // name that nobody else uses
  std::uint32_t domain = 42;
  double seconds = 5;
};

/// A socket on loopback. The echo process announces itself to its port.
class RoundTripMeter {
 public:
  static Result<RoundTripMeter> Open();
  RoundTripMeter(RoundTripMeter&& other) noexcept;
  RoundTripMeter& operator=(RoundTripMeter&&) = delete;
  ~RoundTripMeter();

  std::uint16_t port() const noexcept { return port_; }
  /// Waits up to 10 s for the echo, then measures.
  Result<RoundTrips> Measure(const RoundTripOptions& options);

 private:
  RoundTripMeter() = default;
  Result<bool> MeetEcho() const;

  int socket_ = -1;
  std::uint16_t port_ = 0;
};

/// Runs the other process: sends back all that comes until `stop` is set.
Result<bool> EchoRoundTrips(const RoundTripOptions& options, std::uint16_t port,
                            const std::atomic<bool>& stop);

}  // namespace tandem
