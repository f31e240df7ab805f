#include "tests/app/device/drivers/network/far_end.h"

#include <algorithm>
#include <array>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "app/device/tandem_device.h"
#include "engine/realtime/clock.h"

namespace tandem::testing {
namespace {

constexpr std::int64_t kStateNs = 1'000'000;
constexpr std::int64_t kHelloNs = 20'000'000;
constexpr std::size_t kKept = 200;

int UdpSocket() {
  return socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
}

void SendTo(int from, int port, const Bytes& bytes) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<std::uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  [[maybe_unused]] const ssize_t sent = sendto(from, bytes.data(), bytes.size(), MSG_DONTWAIT,
                                               reinterpret_cast<const sockaddr*>(&to), sizeof to);
}

}  // namespace

net::PacketWriter DeviceEnd::Begin(net::Kind kind, std::int64_t now_ns) {
  header_.kind = kind;
  header_.time_ns = now_ns;
  ++header_.sequence;
  return net::PacketWriter(header_, !key_.empty());
}

Bytes DeviceEnd::Sealed(net::PacketWriter& packet) const {
  if (!key_.empty()) std::ranges::copy(key_.CodeOf(packet.text()), packet.code().begin());
  return {packet.bytes().begin(), packet.bytes().end()};
}

Bytes DeviceEnd::Hello(std::int64_t now_ns, const net::Hello& hello) {
  net::PacketWriter packet = Begin(net::Kind::kHello, now_ns);
  packet.Put(hello);
  return Sealed(packet);
}

Bytes DeviceEnd::State(std::int64_t now_ns, const net::State& state) {
  net::PacketWriter packet = Begin(net::Kind::kState, now_ns);
  packet.Put(state);
  return Sealed(packet);
}

Bytes DeviceEnd::End(std::int64_t now_ns) {
  net::PacketWriter packet = Begin(net::Kind::kDeviceEnds, now_ns);
  return Sealed(packet);
}

bool DeviceEnd::Take(std::span<const std::uint8_t> bytes, std::int64_t) {
  net::Header header;
  if (net::ReadHeader(bytes, !key_.empty(), header) != net::Form::kSound) return false;
  if (static_cast<int>(header.kind) < 128) return false;
  if (!key_.empty() &&
      !key_.Holds(bytes.first(bytes.size() - net::kCodeBytes), bytes.last(net::kCodeBytes))) {
    return false;
  }
  if (header.device_session != header_.device_session) return false;
  if (header.kind == net::Kind::kWelcome) {
    header_.host_session = header.host_session;
    header_.echo_ns = header.time_ns;
    newest_ = 0;
    return true;
  }
  if (header.host_session != header_.host_session || header.sequence <= newest_) return false;
  newest_ = header.sequence;
  header_.echo_ns = std::max(header_.echo_ns, header.time_ns);
  if (header.kind == net::Kind::kHostEnds) {
    host_ended_ = true;
    force_ = {};
    return true;
  }
  force_ = net::ReadForce(bytes);
  force_echo_ns_ = header.echo_ns;
  ++forces_;
  return true;
}

net::Force DeviceEnd::ForceAt(std::int64_t now_ns) const {
  return AgeAt(now_ns) <= 1000 * static_cast<std::int64_t>(force_.expiry_us) ? force_
                                                                             : net::Force{};
}

FarEnd::FarEnd(int port, net::Key key, std::uint64_t session, double x)
    : port_(port),
      socket_(UdpSocket()),
      stranger_(UdpSocket()),
      x_(x),
      end_(std::move(key), session),
      thread_([this] {
        Run();
      }) {}

FarEnd::~FarEnd() {
  ending_ = true;
  thread_.join();
  close(socket_);
  close(stranger_);
}

void FarEnd::Run() {
  std::int64_t next_ns = MonotonicNowNs();
  while (!ending_) {
    const std::int64_t now_ns = MonotonicNowNs();
    {
      const std::lock_guard lock(mutex_);
      std::array<std::uint8_t, 512> room{};
      for (;;) {
        const ssize_t size = recv(socket_, room.data(), room.size(), MSG_DONTWAIT);
        if (size < 0) break;
        const std::uint64_t before = end_.forces();
        if (end_.Take({room.data(), static_cast<std::size_t>(size)}, now_ns) &&
            end_.forces() != before) {
          ages_.Add(end_.AgeAt(MonotonicNowNs()));
        }
      }
      if (!silent_ && now_ns >= next_ns) {
        net::State state;
        state.valid = TANDEM_HAS_POSE | TANDEM_HAS_VELOCITY;
        state.position = {x_, 0.2, 0.3};
        if (!end_.welcome()) {
          Transmit(end_.Hello(now_ns));
        } else if (ends_) {
          Transmit(end_.End(now_ns));
          silent_ = true;
        } else {
          Transmit(end_.State(now_ns, state));
        }
        next_ns = now_ns + (end_.welcome() ? kStateNs : kHelloNs);
      }
    }
    MachineClock().SleepUntil(MonotonicNowNs() + kStateNs / 4);
  }
}

void FarEnd::Transmit(const Bytes& bytes) {
  sent_.push_back(bytes);
  if (sent_.size() > kKept) sent_.pop_front();
  const auto falls = [this](double share) {
    return std::uniform_real_distribution<double>(0, 1)(random_) < share;
  };
  if (falls(network_.loss)) return;
  if (held_.empty() && falls(network_.swapped)) {
    held_ = bytes;
    return;
  }
  SendTo(socket_, port_, bytes);
  if (falls(network_.twice)) SendTo(socket_, port_, bytes);
  if (!held_.empty()) SendTo(socket_, port_, held_);
  held_.clear();
}

void FarEnd::SetNetwork(const Network& network) {
  const std::lock_guard lock(mutex_);
  network_ = network;
}

void FarEnd::Move() {
  const std::lock_guard lock(mutex_);
  close(socket_);
  // the old number goes to a socket that nobody reads, so that the new one is another port
  socket_ = UdpSocket();
}

void FarEnd::Inject(const Bytes& bytes, bool own) const {
  SendTo(own ? socket_.load() : stranger_, port_, bytes);
}

net::Force FarEnd::force() const {
  const std::lock_guard lock(mutex_);
  return end_.ForceAt(MonotonicNowNs());
}
bool FarEnd::host_ended() const {
  const std::lock_guard lock(mutex_);
  return end_.host_ended();
}
std::uint64_t FarEnd::forces() const {
  const std::lock_guard lock(mutex_);
  return end_.forces();
}
Histogram FarEnd::ages() const {
  const std::lock_guard lock(mutex_);
  return ages_;
}
std::deque<Bytes> FarEnd::sent() const {
  const std::lock_guard lock(mutex_);
  return sent_;
}

}  // namespace tandem::testing
