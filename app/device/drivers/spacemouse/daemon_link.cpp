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

// a number that no daemon of version 0 takes for a sensitivity: it is none
constexpr std::int32_t kHello = 0x7faa5501;
constexpr std::uint32_t kHelloMask = 0xffffff00U;
constexpr std::int32_t kAnswerMark = 0x7faa0000;
constexpr std::int32_t kAskAxes = 0x2002;
constexpr std::size_t kPacketBytes = 32;

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
  socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (socket_ < 0 || connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
    const std::string why = std::strerror(errno);  // NOLINT(concurrency-mt-unsafe)
    Close();
    return socket + ": " + why;
  }
  version_ = 0;
  if (!Send(&kHello, sizeof kHello)) return socket + ": the daemon hung up";
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(kHandshakeMs);
  while (received_.size() < sizeof kHello) {
    if (!IsReadable(socket_, MillisecondsUntil(until))) break;
    if (!Receive()) return socket + ": the daemon hung up";
  }
  if (received_.size() >= sizeof kHello) {
    std::int32_t answer = 0;
    std::memcpy(&answer, received_.data(), sizeof answer);
    // anything else is the first word of an event
    if ((static_cast<std::uint32_t>(answer) & kHelloMask) ==
        (static_cast<std::uint32_t>(kHello) & kHelloMask)) {
      version_ = answer & 0xff;
      received_.erase(0, sizeof answer);
    }
  }
  if (version_ > 0) return {};
  const float sensitivity = 1;
  return Send(&sensitivity, sizeof sensitivity) ? "" : socket + ": the daemon hung up";
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
  if (received_.size() < kPacketBytes) return false;
  std::memcpy(packet.data(), received_.data(), kPacketBytes);
  received_.erase(0, kPacketBytes);
  return true;
}

bool DaemonLink::Wait(int timeout_ms, const std::function<void(const DaemonEvent&)>& take) {
  if (socket_ < 0) return false;
  const bool is_there =
      received_.size() >= kPacketBytes || !IsReadable(socket_, timeout_ms) || Receive();
  for (Packet packet; TakePacket(packet);) {
    DaemonEvent event;
    event.kind = packet[0];
    std::copy(packet.begin() + 1, packet.end(), event.word.begin());
    // an answer to a request that nobody waits for any more is passed over
    if (event.kind >= 0 && event.kind < kAnswerMark) take(event);
  }
  return is_there;
}

bool DaemonLink::HasDevice(const std::function<void(const DaemonEvent&)>& take) {
  if (version_ == 0) return true;
  const Packet request{kAnswerMark | kAskAxes};
  if (!Send(request.data(), kPacketBytes)) return false;
  const auto until = std::chrono::steady_clock::now() + std::chrono::milliseconds(kAnswerMs);
  do {
    for (Packet packet; TakePacket(packet);) {
      if (packet[0] == (kAnswerMark | kAskAxes)) return packet[7] == 0 && packet[1] > 0;
      DaemonEvent event;
      event.kind = packet[0];
      std::copy(packet.begin() + 1, packet.end(), event.word.begin());
      if (event.kind >= 0 && event.kind < kAnswerMark) take(event);
    }
  } while (IsReadable(socket_, MillisecondsUntil(until)) && Receive());
  return false;
}

void DaemonLink::Close() {
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
  received_.clear();
}

}  // namespace tandem::driver
