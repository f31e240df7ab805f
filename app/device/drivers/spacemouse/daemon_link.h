#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

namespace tandem::driver {

/// What the daemon tells: the packet's first word, and the seven that follow.
struct DaemonEvent {
  enum Kind : std::int32_t { kMotion = 0, kPress = 1, kRelease = 2, kDevice = 3 };
  std::int32_t kind = 0;
  std::array<std::int32_t, 7> word{};
};

/// A connection to spacenavd, by its socket and both versions of its protocol. Version 0 sends
/// events of 32 bytes and takes nothing but a sensitivity; version 1 has a handshake and requests,
/// whose answers come between events. Used by one thread.
class DaemonLink {
 public:
  static constexpr int kHandshakeMs = 300;
  static constexpr int kAnswerMs = 400;

  /// Where the daemon listens: SPNAV_SOCKET, what /etc/spnavrc says, /var/run/spnav.sock.
  static std::string DefaultSocket();

  DaemonLink() = default;
  ~DaemonLink() { Close(); }
  DaemonLink(const DaemonLink&) = delete;
  DaemonLink& operator=(const DaemonLink&) = delete;

  /// Connects and agrees on the protocol. Returns the fault; empty: none.
  std::string Connect(const std::string& socket);
  /// Waits so long at the most for events and gives each to `take`; false: the daemon is gone.
  bool Wait(int timeout_ms, const std::function<void(const DaemonEvent&)>& take);
  /// Whether a device is plugged in, as the daemon says. A daemon of version 0 cannot say: it
  /// counts as one that has a device. Events that come meanwhile go to `take`.
  bool HasDevice(const std::function<void(const DaemonEvent&)>& take);
  int version() const { return version_; }
  void Close();

 private:
  using Packet = std::array<std::int32_t, 8>;
  bool Send(const void* bytes, std::size_t size) const;
  /// Takes what has come in; false: the daemon is gone.
  bool Receive();
  bool TakePacket(Packet& packet);

  int socket_ = -1;
  int version_ = 0;
  std::string received_;
};

}  // namespace tandem::driver
