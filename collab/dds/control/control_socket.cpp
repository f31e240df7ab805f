#include "collab/dds/control/control_socket.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "collab/dds/control/control_folder.h"

namespace tandem {

namespace {

constexpr int kBacklog = 16;  // programs that connect at once

OwnDescriptor NewSocket() {
  return OwnDescriptor(socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

/// The address of a controller's socket. It names the folder by an open descriptor. So a long path
/// fits, and nobody puts another folder in its place meanwhile.
class SocketAddress {
 public:
  SocketAddress(const std::filesystem::path& folder, const std::string& name)
      : folder_(open(folder.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC)) {
    const std::string path =
        "/proc/self/fd/" + std::to_string(folder_.get()) + "/" + SocketOf(name);
    struct stat facts {};
    usable_ = folder_.get() >= 0 && fstat(folder_.get(), &facts) == 0 &&
              facts.st_uid == geteuid() && path.size() < sizeof address_.sun_path;
    address_.sun_family = AF_UNIX;
    if (usable_) std::memcpy(address_.sun_path, path.data(), path.size());
  }
  bool usable() const noexcept { return usable_; }
  const char* path() const noexcept { return address_.sun_path; }
  const sockaddr* get() const noexcept { return reinterpret_cast<const sockaddr*>(&address_); }
  static constexpr socklen_t kSize = sizeof(sockaddr_un);

 private:
  OwnDescriptor folder_;
  sockaddr_un address_{};
  bool usable_ = false;
};

bool IsOfThisUser(int socket) {
  ucred other{};
  socklen_t size = sizeof other;
  return getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &other, &size) == 0 && other.uid == geteuid();
}

}  // namespace

OwnDescriptor::OwnDescriptor(OwnDescriptor&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

OwnDescriptor& OwnDescriptor::operator=(OwnDescriptor&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

OwnDescriptor::~OwnDescriptor() {
  if (descriptor_ >= 0) close(descriptor_);
}

ControlConnection::ControlConnection(OwnDescriptor socket) noexcept : socket_(std::move(socket)) {
  // room for the largest packet; the kernel doubles it
  const int room = static_cast<int>(kLargestPacket);
  setsockopt(socket_.get(), SOL_SOCKET, SO_SNDBUF, &room, sizeof room);
}

Result<ControlConnection> ControlConnection::To(const std::filesystem::path& folder,
                                                const std::string& name) {
  const SocketAddress address(folder, name);
  OwnDescriptor socket = NewSocket();
  if (!address.usable() || socket.get() < 0 ||
      connect(socket.get(), address.get(), SocketAddress::kSize) != 0) {
    return Error{"no controller '" + name + "' on this machine"};
  }
  if (!IsOfThisUser(socket.get())) {
    return Error{"the controller '" + name + "' belongs to another user of this machine"};
  }
  return ControlConnection(std::move(socket));
}

ControlConnection::Outcome ControlConnection::Send(std::span<const char> packet) noexcept {
  for (;;) {
    const ssize_t sent =
        send(socket_.get(), packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent >= 0) return Outcome::kDone;
    if (errno == EINTR) continue;
    if (errno == EAGAIN || errno == ENOBUFS) return Outcome::kLater;
    return errno == EMSGSIZE ? Outcome::kUnusable : Outcome::kGone;
  }
}

ControlConnection::Outcome ControlConnection::Receive(std::vector<char>& packet) {
  packet.resize(kLargestPacket);
  for (;;) {
    const ssize_t size =
        recv(socket_.get(), packet.data(), packet.size(), MSG_DONTWAIT | MSG_TRUNC);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && errno == EAGAIN) return Outcome::kLater;
    if (size <= 0) return Outcome::kGone;
    if (static_cast<std::size_t>(size) > packet.size()) return Outcome::kUnusable;
    packet.resize(static_cast<std::size_t>(size));
    return Outcome::kDone;
  }
}

Result<ControlListener> ControlListener::Open(const std::filesystem::path& folder,
                                              const std::string& name) {
  const SocketAddress address(folder, name);
  OwnDescriptor socket = NewSocket();
  if (!address.usable() || socket.get() < 0) {
    return Error{folder.string() + ": the controller's socket cannot be opened there"};
  }
  unlink(address.path());
  fchmod(socket.get(), 0600);
  if (bind(socket.get(), address.get(), SocketAddress::kSize) != 0 ||
      listen(socket.get(), kBacklog) != 0) {
    return Error{folder.string() + ": the controller's socket cannot be opened there: " +
                 std::generic_category().message(errno)};
  }
  return ControlListener(std::move(socket));
}

ControlListener::Arrival ControlListener::Accept() {
  OwnDescriptor host(accept4(socket_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  if (host.get() < 0) return {};
  if (!IsOfThisUser(host.get())) return {.host = std::nullopt, .anothers = true};
  return {.host = ControlConnection(std::move(host)), .anothers = false};
}

}  // namespace tandem
