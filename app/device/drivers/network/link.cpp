#include "app/device/drivers/network/link.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <utility>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "engine/realtime/clock.h"
#include "engine/realtime/realtime_setup.h"

namespace tandem::driver::network {
namespace {

constexpr int kPriority = 39;                     // below the device's loop
constexpr std::int64_t kLateNs = 1'500'000;       // time after which a force is sent without a
                                                  // write
constexpr std::int64_t kToSilentNs = 50'000'000;  // time between forces to a silent device
constexpr std::int64_t kNapNs = 250'000;          // time between looks for a write
constexpr std::int64_t kLookNs = 20'000'000;
constexpr int kMostAtOnce = 64;          // packets before the next force
constexpr std::int64_t kDrift = 10'000;  // a clock drifts at most one part in this many

}  // namespace

Link::Link(Key key, Key secret, const Session::Rules& rules, const TandemDeviceHost& host)
    : session_(std::move(key), std::move(secret), rules), rules_(rules), host_(&host) {
  newest_.Write(reading_);
}

Link::~Link() {
  End();
  if (socket_ >= 0) close(socket_);
  if (bell_ >= 0) close(bell_);
}

bool Link::Open(const Address& here, std::string& fault) {
  bell_ = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  socket_ = socket(here.storage.ss_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (bell_ < 0 || socket_ < 0) {
    fault = std::string("a socket: ") + std::strerror(errno);
    return false;
  }
  if (bind(socket_, here.data(), here.length) == 0) return true;
  const int error = errno;
  fault =
      here.text() + ": " + std::strerror(error) +
      (error == EADDRINUSE ? "; end the program that uses it, or give another listen=ADDRESS:PORT"
                           : "; give an address of this machine as listen=ADDRESS:PORT");
  return false;
}

void Link::WaitUntil(std::int64_t until_ns) {
  const std::int64_t left_ns = std::max<std::int64_t>(0, until_ns - MonotonicNowNs());
  const timespec left{static_cast<time_t>(left_ns / 1'000'000'000),
                      static_cast<long>(left_ns % 1'000'000'000)};
  std::array<pollfd, 2> watched{{{socket_, POLLIN, 0}, {bell_, POLLIN, 0}}};
  if (ppoll(watched.data(), watched.size(), &left, nullptr) <= 0) return;
  std::uint64_t rings = 0;
  [[maybe_unused]] const ssize_t rung = read(bell_, &rings, sizeof rings);
}

bool Link::Await(std::int64_t wait_ns) {
  const std::int64_t until_ns = MonotonicNowNs() + wait_ns;
  while (session_.sessions() == 0 && MonotonicNowNs() < until_ns) {
    WaitUntil(std::min(until_ns, MonotonicNowNs() + kLookNs));
    Receive();
  }
  return session_.sessions() != 0;
}

void Link::Start() {
  thread_ = std::thread([this] {
    EnterRealtime(kPriority);
    try {
      Run();
    } catch (const std::exception& thrown) {
      Publish(TANDEM_BROKEN);
      trouble_.Say(thrown.what());
    }
  });
}

void Link::End() {
  ending_.store(true);
  Ring();
  if (thread_.joinable()) thread_.join();
}

void Link::Ring() noexcept {
  const int error = errno;  // errno of the code that a signal handler has interrupted
  const std::uint64_t once = 1;
  [[maybe_unused]] const ssize_t rung = write(bell_, &once, sizeof once);
  errno = error;
}

void Link::Wrote(std::int64_t based_on_ns) noexcept {
  based_on_ns_.store(based_on_ns, std::memory_order_relaxed);
  stopped_.store(false, std::memory_order_relaxed);
  // no ring: the thread that it wakes could take the loop's processor
  writes_.fetch_add(1, std::memory_order_release);
}

void Link::Stop() noexcept {
  stopped_.store(true);
  Ring();
}

void Link::Run() {
  const std::int64_t to_silent_ns = std::min(kToSilentNs, rules_.stale_ns / 2);
  std::uint32_t writes = 0;
  bool stopped = false;
  while (!ending_.load()) {
    // a silent device still gets packets, less often, so that it can resume
    const bool well = reading_.condition == TANDEM_OK;
    const std::int64_t due_ns = forced_ns_ + (well ? kLateNs : to_silent_ns);
    WaitUntil(std::min(due_ns, MonotonicNowNs() + (well ? kNapNs : kLookNs)));
    Receive();
    LookForSilence();
    const std::uint32_t written = writes_.load(std::memory_order_acquire);
    const bool stops = stopped_.load();
    const bool news = well && (written != writes || stops != stopped);
    writes = written;
    stopped = stops;
    if (session_.on() && (news || MonotonicNowNs() >= due_ns)) SendForce();
    if (!session_.on()) forced_ns_ = MonotonicNowNs();
  }
  if (!session_.on()) return;
  stopped_.store(true);
  SendForce();
  Send(session_.EndPacket(MonotonicNowNs()), session_.address());
}

void Link::Receive() {
  std::array<std::uint8_t, kLongestBytes> room{};
  for (int i = 0; i < kMostAtOnce; ++i) {
    Address from;
    from.length = sizeof from.storage;
    const ssize_t size = recvfrom(socket_, room.data(), room.size(), MSG_DONTWAIT | MSG_TRUNC,
                                  from.data(), &from.length);
    if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return;
    if (size < 0) continue;  // report that an earlier packet did not arrive
    // a packet longer than the buffer is refused for its length
    const auto count = std::min(static_cast<std::size_t>(size), room.size());
    const Session::Taken taken = session_.Take({room.data(), count}, from, MonotonicNowNs());
    if (taken.answer) Send(*taken.answer, from);
    if (taken.state) PublishState();
  }
}

void Link::PublishState() {
  const std::int64_t now_ns = session_.state_ns();
  const std::int64_t offset_ns = now_ns - session_.sent_ns();
  // the packet with the shortest way gives the best offset of the clocks; the drift ages it
  if (offset_of_ != session_.sessions()) {
    offset_of_ = session_.sessions();
    offset_ns_ = offset_ns;
  } else {
    offset_ns_ = std::min(offset_ns, offset_ns_ + (now_ns - reading_.came_ns) / kDrift);
  }
  ++reading_.number;
  reading_.came_ns = now_ns;
  reading_.sent_ns = session_.sent_ns();
  reading_.measured_ns = std::min(now_ns, session_.sent_ns() + offset_ns_);
  reading_.state = session_.state();
  if (session_.echo_ns() != echo_ns_) {
    echo_ns_ = session_.echo_ns();
    round_trips_.Add(now_ns - echo_ns_);
  }
  if (reading_.condition != TANDEM_OK) trouble_.Say({});
  Publish(TANDEM_OK);
}

void Link::Publish(std::int32_t condition) {
  reading_.condition = condition;
  newest_.Write(reading_);
}

void Link::LookForSilence() {
  if (reading_.condition != TANDEM_OK || session_.alive(MonotonicNowNs())) return;
  std::string line = session_.ended() ? "the device at " + session_.address().text() + " has ended"
                                      : "the device at " + session_.address().text() + " is silent";
  const std::string refusals = session_.Refusals();
  line += ": start its program again";
  if (!refusals.empty()) line += " (" + refusals + ")";
  trouble_.Say(line);
  Publish(TANDEM_UNPLUGGED);
}

void Link::SendForce() {
  TandemDeviceForce given{};
  given.struct_size = sizeof given;
  host_->take(host_->context, &given);
  const std::int64_t now_ns = MonotonicNowNs();
  forced_ns_ = now_ns;
  Force force;
  const auto is_number = [](double x) {
    return std::isfinite(x);
  };
  if (reading_.condition == TANDEM_OK && !stopped_.load() &&
      std::all_of(given.force, given.force + 3, is_number) &&
      std::all_of(given.moment, given.moment + 3, is_number)) {
    std::copy_n(given.force, 3, force.force.begin());
    std::copy_n(given.moment, 3, force.moment.begin());
  }
  Send(session_.ForcePacket(force, based_on_ns_.load(std::memory_order_relaxed), now_ns),
       session_.address());
}

void Link::Send(const PacketWriter& packet, const Address& to) {
  // a packet that cannot be sent now is lost, as on a network: the next follows a millisecond later
  [[maybe_unused]] const ssize_t sent =
      sendto(socket_, packet.bytes().data(), packet.bytes().size(), MSG_DONTWAIT | MSG_NOSIGNAL,
             to.data(), to.length);
}

}  // namespace tandem::driver::network
