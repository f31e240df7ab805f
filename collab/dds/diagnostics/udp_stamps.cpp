#include "collab/dds/diagnostics/udp_stamps.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <ctime>

#include <poll.h>
#include <sys/socket.h>

#include "engine/realtime/clock.h"

namespace tandem {

namespace {

std::int64_t NsOf(const timespec& time) {
  return static_cast<std::int64_t>(time.tv_sec) * 1'000'000'000 + time.tv_nsec;
}

/// Returns the time since the kernel stamped the packet; 0: it has no stamp.
std::int64_t AgeOf(msghdr& message) {
  for (cmsghdr* note = CMSG_FIRSTHDR(&message); note != nullptr;
       note = CMSG_NXTHDR(&message, note)) {
    if (note->cmsg_level != SOL_SOCKET || note->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec stamp{};
    std::memcpy(&stamp, CMSG_DATA(note), sizeof stamp);
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);  // the kernel stamps by this clock
    // a step of that clock between stamp and reading is not an age
    constexpr std::int64_t kOldest = 60'000'000'000;
    const std::int64_t age_ns = NsOf(now) - NsOf(stamp);
    return age_ns < 0 || age_ns > kOldest ? 0 : age_ns;
  }
  return 0;
}

}  // namespace

void StampArrivals(int socket) {
  const int on = 1;
  setsockopt(socket, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
}

std::optional<StampedPacket> ReceiveStamped(int socket, std::span<std::byte> room) {
  StampedPacket packet;
  alignas(cmsghdr) std::array<char, 128> notes{};
  iovec into{room.data(), room.size()};
  msghdr message{};
  message.msg_name = &packet.from;
  message.msg_namelen = sizeof packet.from;
  message.msg_iov = &into;
  message.msg_iovlen = 1;
  message.msg_control = notes.data();
  message.msg_controllen = notes.size();
  const ssize_t got = recvmsg(socket, &message, MSG_DONTWAIT);
  if (got < 0) return std::nullopt;
  packet.bytes = static_cast<std::size_t>(got);
  packet.arrival_ns = MonotonicNowNs() - AgeOf(message);
  return packet;
}

void WaitForPacket(int socket, std::int64_t until_ns) {
  const std::int64_t wait_ns = std::max<std::int64_t>(0, until_ns - MonotonicNowNs());
  const timespec timeout{static_cast<time_t>(wait_ns / 1'000'000'000),
                         static_cast<long>(wait_ns % 1'000'000'000)};
  pollfd wait{socket, POLLIN, 0};
  ppoll(&wait, 1, &timeout, nullptr);
}

}  // namespace tandem
