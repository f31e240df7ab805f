#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace tandem::driver {

/// An event of the daemon: the packet's first word, and the seven words after it.
struct DaemonEvent {
  enum Kind : std::int32_t { kMotion = 0, kPress = 1, kRelease = 2, kDevice = 3 };
  std::int32_t kind = 0;
  std::array<std::int32_t, 7> word{};
};

/// A connection to spacenavd through its socket, in both versions of its protocol. Version 0 sends
/// events of 32 bytes and accepts only a sensitivity. Version 1 has a handshake and requests, whose
/// answers come between events. Used by one thread.
class DaemonLink {
 public:
  static constexpr int kHandshakeMs = 300;
  static constexpr int kAnswerMs = 400;

  /// Returns the daemon's socket: SPNAV_SOCKET, else the entry of /etc/spnavrc, else
  /// /var/run/spnav.sock.
  static std::string DefaultSocket();

  DaemonLink() = default;
  ~DaemonLink() { Close(); }
  DaemonLink(const DaemonLink&) = delete;
  DaemonLink& operator=(const DaemonLink&) = delete;

  /// Connects and agrees on the protocol's version. Returns the fault; empty: none.
  std::string Connect(const std::string& socket);
  /// Waits at most `timeout_ms` for events and gives each to `take`. False: the daemon is gone, or
  /// answered the handshake too late.
  bool Wait(int timeout_ms, const std::function<void(const DaemonEvent&)>& take);
  enum class Devices : std::uint8_t { kNone, kSome, kNoAnswer };
  /// Asks the daemon whether a device is plugged in. A daemon of version 0 cannot say and counts as
  /// having one. Events that come meanwhile go to `take`.
  Devices AskDevices(const std::function<void(const DaemonEvent&)>& take);
  int version() const { return version_; }
  void Close();

 private:
  using Packet = std::array<std::int32_t, 8>;
  bool Send(const void* bytes, std::size_t size) const;
  /// Receives bytes. False: the daemon is gone.
  bool Receive();
  /// Takes the next whole packet. Notes the handshake's answer, which is no packet.
  bool TakePacket(Packet& packet);
  void Give(const Packet& packet, const std::function<void(const DaemonEvent&)>& take) const;

  int socket_ = -1;
  int version_ = 0;
  bool agreed_ = false;   // true: the version is settled
  bool is_late_ = false;  // true: the handshake's answer came after that
  std::string received_;
  std::vector<Packet> early_;  // events from before that
};

}  // namespace tandem::driver
