#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/result.h"

namespace tandem {

/// A descriptor of the kernel that closes with its object.
class OwnDescriptor {
 public:
  explicit OwnDescriptor(int descriptor = -1) noexcept : descriptor_(descriptor) {}
  OwnDescriptor(OwnDescriptor&& other) noexcept;
  OwnDescriptor& operator=(OwnDescriptor&& other) noexcept;
  ~OwnDescriptor();
  int get() const noexcept { return descriptor_; }

 private:
  int descriptor_;
};

/// One end of a connection between a host and a controller: a local socket that keeps packets whole
/// and in order. Both ends belong to one user of the machine, by the word of the kernel
/// (SO_PEERCRED). No call waits.
class ControlConnection {
 public:
  static constexpr std::size_t kLargestPacket = 393'216;  // bytes

  enum class Outcome : std::uint8_t {
    kDone,
    kLater,     // no packet waits, or the other end has no room for one more
    kUnusable,  // a packet that is too large
    kGone       // the other end is closed
  };

  /// Connects to the controller of that name in a ControlFolder(). Error: none is there, or another
  /// user owns it.
  static Result<ControlConnection> To(const std::filesystem::path& folder, const std::string& name);
  /// Takes over a connected socket.
  explicit ControlConnection(OwnDescriptor socket) noexcept;

  int descriptor() const noexcept { return socket_.get(); }
  Outcome Send(std::span<const char> packet) noexcept;
  Outcome Receive(std::vector<char>& packet);

 private:
  OwnDescriptor socket_;
};

/// The socket of a controller, to which its hosts connect.
class ControlListener {
 public:
  /// Opens the socket in a ControlFolder(). A socket that a killed controller left there goes.
  static Result<ControlListener> Open(const std::filesystem::path& folder, const std::string& name);

  struct Arrival {
    std::optional<ControlConnection> host;
    bool anothers = false;  // a program of another user, whose connection is closed again
  };
  /// Takes the next program that connects; neither: none waits.
  Arrival Accept();
  int descriptor() const noexcept { return socket_.get(); }

 private:
  explicit ControlListener(OwnDescriptor socket) noexcept : socket_(std::move(socket)) {}
  OwnDescriptor socket_;
};

}  // namespace tandem
