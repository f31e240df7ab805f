#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

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
  /// Waits so long at the most for events and gives each to `take`; false: the daemon is gone, or
  /// has answered the handshake when nobody waited for that any more.
  bool Wait(int timeout_ms, const std::function<void(const DaemonEvent&)>& take);
  enum class Devices : std::uint8_t { kNone, kSome, kNoAnswer };
  /// Asks the daemon whether a device is plugged in. One of version 0 cannot say: it counts as one
  /// that has some. Events that come meanwhile go to `take`.
  Devices AskDevices(const std::function<void(const DaemonEvent&)>& take);
  int version() const { return version_; }
  void Close();

 private:
  using Packet = std::array<std::int32_t, 8>;
  bool Send(const void* bytes, std::size_t size) const;
  /// Takes what has come in; false: the daemon is gone.
  bool Receive();
  /// The next whole packet. The handshake's answer is none: it is noted.
  bool TakePacket(Packet& packet);
  void Give(const Packet& packet, const std::function<void(const DaemonEvent&)>& take) const;

  int socket_ = -1;
  int version_ = 0;
  bool agreed_ = false;   // on the version
  bool is_late_ = false;  // the answer to the handshake came after that
  std::string received_;
  std::vector<Packet> early_;  // events from before that
};

}  // namespace tandem::driver
