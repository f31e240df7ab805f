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

/// The newest known state of the handle.
struct Reading {
  std::uint64_t number = 0;
  std::int32_t condition = TANDEM_UNPLUGGED;
  std::uint32_t padding = 0;
  std::int64_t came_ns = 0;      // Tandem's clock
  std::int64_t measured_ns = 0;  // Tandem's clock, as well as the two clocks can be compared
  std::int64_t sent_ns = 0;      // device's clock
  State state;
};

/// The socket, and the thread that owns it. The thread takes each packet as it comes. It sends a
/// force within a quarter of a millisecond after each Wrote(), or 1.5 ms after the last force where
/// the loop is late. It asks the host's take() for the force.
///
/// Open(), Await(), Start() and End() are for the main thread, Newest() and Wrote() for the loop's,
/// Stop() for any thread and for signal handlers.
class Link {
 public:
  Link(Key key, Key secret, const Session::Rules& rules, const TandemDeviceHost& host);
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Binds the address. False: `fault` says why.
  bool Open(const Address& here, std::string& fault);
  /// Waits until a device has begun a session. False: none has.
  bool Await(std::int64_t wait_ns);
  void Start();
  /// Sends a last force of zero and a goodbye, and ends the thread.
  void End();

  bool Newest(Reading& reading) const noexcept { return newest_.Read(reading); }
  /// Reports that the host has a force that follows from the state sent at `based_on_ns`.
  void Wrote(std::int64_t based_on_ns) noexcept;
  void Stop() noexcept;
  std::string trouble() const { return trouble_.line(); }
  /// Allowed only while no thread runs.
  const Session& session() const { return session_; }
  const Histogram& round_trips() const { return round_trips_; }

 private:
  void Run();
  /// Waits for a packet or a ring, at most until `until_ns`.
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
  int bell_ = -1;  // eventfd that a signal handler may write
  Seqlock<Reading> newest_;
  Trouble trouble_;
  std::atomic<std::int64_t> based_on_ns_{0};
  std::atomic<std::uint32_t> writes_{0};
  std::atomic<bool> stopped_{false};
  std::atomic<bool> ending_{false};

  // used by the thread alone
  Reading reading_;
  std::uint64_t offset_of_ = 0;  // session of the offset
  std::int64_t offset_ns_ = 0;   // Tandem's clock minus the device's, estimated from packets
  std::int64_t forced_ns_ = 0;   // time of the last force
  std::int64_t echo_ns_ = 0;     // echo of the newest state; each is one round trip
  Histogram round_trips_;
  std::thread thread_;
};

}  // namespace tandem::driver::network
