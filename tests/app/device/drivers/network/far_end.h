#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <random>
#include <span>
#include <thread>
#include <vector>

#include "app/device/drivers/network/address.h"
#include "app/device/drivers/network/key.h"
#include "app/device/drivers/network/packet.h"
#include "app/device/drivers/network/session.h"
#include "engine/realtime/histogram.h"

namespace tandem::testing {

namespace net = driver::network;
using Bytes = std::vector<std::uint8_t>;

inline net::Hello SomeHello() {
  net::Hello hello;
  hello.freedoms_in = 6;
  hello.freedoms_out = 3;
  hello.rate_hz = 1000;
  hello.peak_force = 8;
  hello.name = {"fake"};
  return hello;
}

/// The device's end of the protocol, as docs/devices.md has it, without a socket.
class DeviceEnd {
 public:
  explicit DeviceEnd(net::Key key = {}, std::uint64_t session = 7) : key_(std::move(key)) {
    header_.device_session = session;
  }
  Bytes Hello(std::int64_t now_ns, const net::Hello& hello = SomeHello());
  Bytes State(std::int64_t now_ns, const net::State& state);
  Bytes End(std::int64_t now_ns);
  /// Takes what the other end sent. False: the device refuses it.
  bool Take(std::span<const std::uint8_t> bytes, std::int64_t now_ns);

  bool welcome() const { return header_.host_session != 0; }
  bool host_ended() const { return host_ended_; }
  /// Returns the force for the motors: nothing once it is void.
  net::Force ForceAt(std::int64_t now_ns) const;
  /// Returns the age of the state that the newest force follows from.
  std::int64_t AgeAt(std::int64_t now_ns) const { return now_ns - force_echo_ns_; }
  std::uint64_t forces() const { return forces_; }
  /// The header of its packets, in which a test may change the numbers.
  net::Header& header() { return header_; }
  const net::Key& key() const { return key_; }

 private:
  Bytes Sealed(net::PacketWriter& packet) const;
  net::PacketWriter Begin(net::Kind kind, std::int64_t now_ns);

  net::Key key_;
  net::Header header_;  // header of the packets that it sends
  std::uint64_t newest_ = 0;
  net::Force force_;
  std::int64_t force_echo_ns_ = 0;
  std::uint64_t forces_ = 0;
  bool host_ended_ = false;
};

/// A device program: calls until it is welcome, then sends a state each millisecond.
class FarEnd {
 public:
  /// Treatment of its packets by the network.
  struct Network {
    double loss = 0;
    double twice = 0;
    double swapped = 0;  // share of packets that come after the packet behind them
  };
  FarEnd(int port, net::Key key, std::uint64_t session, double x);
  ~FarEnd();
  FarEnd(const FarEnd&) = delete;
  FarEnd& operator=(const FarEnd&) = delete;

  void SetX(double x) { x_ = x; }
  void SetNetwork(const Network& network);
  void SetSilent(bool silent) { silent_ = silent; }
  /// Sends from another port from now on.
  void Move();
  void End() { ends_ = true; }
  net::Force force() const;
  bool host_ended() const;
  std::uint64_t forces() const;
  /// Returns the ages of forces as they came.
  Histogram ages() const;
  /// Returns the newest packets that it sent, newest last.
  std::deque<Bytes> sent() const;
  /// Sends bytes to Tandem; `own`: from the device's own address.
  void Inject(const Bytes& bytes, bool own) const;

 private:
  void Run();
  void Transmit(const Bytes& bytes);

  int port_;
  std::atomic<int> socket_;
  int stranger_;
  std::atomic<double> x_;
  std::atomic<bool> silent_{false};
  std::atomic<bool> ends_{false};
  std::atomic<bool> ending_{false};
  mutable std::mutex mutex_;
  DeviceEnd end_;
  Network network_;
  Histogram ages_;
  std::deque<Bytes> sent_;
  Bytes held_;
  std::mt19937 random_{1};
  std::thread thread_;
};

}  // namespace tandem::testing
