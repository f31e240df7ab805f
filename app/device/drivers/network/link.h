#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "app/device/drivers/network/address.h"
#include "app/device/drivers/network/key.h"
#include "app/device/drivers/network/session.h"
#include "app/device/drivers/trouble.h"
#include "app/device/tandem_device.h"
#include "engine/realtime/histogram.h"
#include "engine/realtime/seqlock.h"

namespace tandem::driver::network {

/// The newest that is known of the handle.
struct Reading {
  std::uint64_t number = 0;
  std::int32_t condition = TANDEM_UNPLUGGED;
  std::uint32_t padding = 0;
  std::int64_t came_ns = 0;      // by our clock
  std::int64_t measured_ns = 0;  // by our clock, as near as the two can be compared
  std::int64_t sent_ns = 0;      // by the device's clock
  State state;
};

/// The socket, and the thread that has it. It takes each packet as it comes, and sends a force
/// within a quarter of a millisecond after each Wrote(), or a millisecond and a half after the last
/// one where the loop is late. It asks the host's take() for that force.
///
/// Open(), Await(), Start() and End() are for the main thread, Newest() and Wrote() for the loop's,
/// Stop() for any thread and for signal handlers.
class Link {
 public:
  Link(Key key, Key secret, const Session::Rules& rules, const TandemDeviceHost& host);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Takes the address. False: `fault` says why.
  bool Open(const Address& here, std::string& fault);
  /// Waits until a device has called. False: none has.
  bool Await(std::int64_t wait_ns);
  void Start();
  /// Sends a last force of zero and a goodbye, and ends the thread.
  void End();

  bool Newest(Reading& reading) const noexcept { return newest_.Read(reading); }
  /// A force was put that follows from the state that was sent at `based_on_ns`.
  void Wrote(std::int64_t based_on_ns) noexcept;
  void Stop() noexcept;
  std::string trouble() const { return trouble_.line(); }
  /// Only where no thread runs.
  const Session& session() const { return session_; }
  const Histogram& round_trips() const { return round_trips_; }

 private:
  void Run();
  /// Waits for a packet or a ring, until a time at the most.
  void WaitUntil(std::int64_t until_ns);
  void Receive();
  void SendForce();
  void Send(const PacketWriter& packet, const Address& to);
  void Publish(std::int32_t condition);
  void PublishState();
  void LookForSilence();
  void Ring() noexcept;

  Session session_;
  Session::Rules rules_;
  const TandemDeviceHost* host_;
  int socket_ = -1;
  int bell_ = -1;  // eventfd: a signal handler may ring it
  Seqlock<Reading> newest_;
  Trouble trouble_;
  std::atomic<std::int64_t> based_on_ns_{0};
  std::atomic<std::uint32_t> writes_{0};
  std::atomic<bool> stopped_{false};
  std::atomic<bool> ending_{false};

  // the thread's
  Reading reading_;
  std::uint64_t offset_of_ = 0;  // session that the offset is of
  std::int64_t offset_ns_ = 0;   // our clock less the device's, as far as packets tell
  std::int64_t forced_ns_ = 0;   // when a force was sent last
  std::int64_t echo_ns_ = 0;     // of the newest state: each is a round trip once
  Histogram round_trips_;
  std::thread thread_;
};

}  // namespace tandem::driver::network
