#include "app/device/drivers/spacemouse/daemon_link.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace tandem::driver {
namespace {

// a bit pattern that is not a number, so that no daemon of version 0 takes it for a sensitivity
constexpr std::int32_t kHello = 0x7faa5501;
constexpr std::uint32_t kHelloMask = 0xffffff00U;
constexpr std::int32_t kAnswerMark = 0x7faa0000;
constexpr std::int32_t kAskAxes = 0x2002;
constexpr std::size_t kPacketBytes = 32;
constexpr std::size_t kMostEarly = 256;

int MillisecondsUntil(std::chrono::steady_clock::time_point until) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
      until - std::chrono::steady_clock::now());
  return static_cast<int>(std::max<std::chrono::milliseconds::rep>(0, left.count()));
}

bool IsReadable(int socket, int timeout_ms) {
  pollfd wait{socket, POLLIN, 0};
  return poll(&wait, 1, timeout_ms) > 0;
}

}  // namespace

std::string DaemonLink::DefaultSocket() {
  if (const char* named = std::getenv("SPNAV_SOCKET"))
    return named;  // NOLINT(concurrency-mt-unsafe)
  std::ifstream settings("/etc/spnavrc");
  for (std::string line; std::getline(settings, line);) {
    std::erase_if(line, [](char c) {
      return c == ' ' || c == '\t';
    });
    if (line.rfind("socket=", 0) == 0 && line.size() > 7) return line.substr(7);
  }
  return "/var/run/spnav.sock";
}

std::string DaemonLink::Connect(const std::string& socket) {
  Close();
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (socket.size() >= sizeof address.sun_path) return socket + ": the name is too long";
  std::memcpy(address.sun_path, socket.c_str(), socket.size() + 1);
  // nonblocking: a daemon whose queue is full would keep connect() waiting
  socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket_ < 0 || connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
    const std::string why = std::strerror(errno);  // NOLINT(concurrency-mt-unsafe)
    Close();
    return socket + ": " + why;
  }
  const std::string gone = socket + ": the daemon closed the connection";
  if (!Send(&kHello, sizeof kHello)) return gone;
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(kHandshakeMs);
  while (version_ == 0 && IsReadable(socket_, MillisecondsUntil(until))) {
    if (!Receive()) return gone;
    for (Packet packet; TakePacket(packet);) {
      if (early_.size() < kMostEarly) early_.push_back(packet);
    }
  }
  agreed_ = true;
  if (version_ > 0) return {};
  // a daemon of version 0 took the handshake for a sensitivity
  const float sensitivity = 1;
  return Send(&sensitivity, sizeof sensitivity) ? "" : gone;
}

bool DaemonLink::Send(const void* bytes, std::size_t size) const {
  return send(socket_, bytes, size, MSG_NOSIGNAL) == static_cast<ssize_t>(size);
}

bool DaemonLink::Receive() {
  std::array<char, 4096> buffer;
  const ssize_t size = recv(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (size < 0) return errno == EAGAIN || errno == EINTR;
  received_.append(buffer.data(), static_cast<std::size_t>(size));
  return size > 0;
}

bool DaemonLink::TakePacket(Packet& packet) {
  std::uint32_t first = 0;
  if (received_.size() < sizeof first) return false;
  std::memcpy(&first, received_.data(), sizeof first);
  if ((first & kHelloMask) == (static_cast<std::uint32_t>(kHello) & kHelloMask)) {
    is_late_ = is_late_ || agreed_;
    version_ = static_cast<int>(first & ~kHelloMask);
    received_.erase(0, sizeof first);
  }
  if (received_.size() < kPacketBytes) return false;
  std::memcpy(packet.data(), received_.data(), kPacketBytes);
  received_.erase(0, kPacketBytes);
  return true;
}

void DaemonLink::Give(const Packet& packet,
                      const std::function<void(const DaemonEvent&)>& take) const {
  // ignores an answer that came too late for its request
  if (packet[0] < 0 || packet[0] >= kAnswerMark) return;
  DaemonEvent event;
  event.kind = packet[0];
  std::copy(packet.begin() + 1, packet.end(), event.word.begin());
  take(event);
}

bool DaemonLink::Wait(int timeout_ms, const std::function<void(const DaemonEvent&)>& take) {
  if (socket_ < 0) return false;
  for (const Packet& packet : early_) Give(packet, take);
  early_.clear();
  const bool is_there =
      received_.size() >= kPacketBytes || !IsReadable(socket_, timeout_ms) || Receive();
  for (Packet packet; TakePacket(packet);) Give(packet, take);
  return is_there && !is_late_;
}

DaemonLink::Devices DaemonLink::AskDevices(const std::function<void(const DaemonEvent&)>& take) {
  if (version_ == 0) return Devices::kSome;
  for (const Packet& packet : early_) Give(packet, take);
  early_.clear();
  constexpr std::int32_t kAxes = kAnswerMark | kAskAxes;
  const Packet request{kAxes};
  if (!Send(request.data(), kPacketBytes)) return Devices::kNoAnswer;
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(kAnswerMs);
  do {
    for (Packet packet; TakePacket(packet);) {
      if (packet[0] == kAxes) {
        return packet[7] == 0 && packet[1] > 0 ? Devices::kSome : Devices::kNone;
      }
      Give(packet, take);
    }
  } while (IsReadable(socket_, MillisecondsUntil(until)) && Receive());
  return Devices::kNoAnswer;
}

void DaemonLink::Close() {
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
  version_ = 0;
  agreed_ = is_late_ = false;
  received_.clear();
  early_.clear();
}

}  // namespace tandem::driver
