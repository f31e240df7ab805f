#include "collab/dds/diagnostics/round_trip.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <thread>
#include <utility>

#include <arpa/inet.h>
#include <semaphore.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/cyclone/cyclone_log.h"
#include "collab/dds/cyclone/qos.h"
#include "collab/dds/transport/domain.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/realtime_setup.h"
#include "tandem.h"  // idlc's

namespace tandem {
namespace {

constexpr int kAskerPriority = 30;
constexpr std::int64_t kPeriodNs = 1'000'000;
constexpr std::int64_t kAnswerNs = 20'000'000;  // a later answer counts as lost
constexpr std::int64_t kMeetNs = 10'000'000'000;
constexpr int kWarmUp = 500;  // round trips that are not counted

// RTPS: the headers of the message, of its time stamp, of the data and of their encoding
constexpr std::size_t kRtpsBytes = 20 + 12 + 24 + 4;
// the struct has the padding of the encoding and no field of variable length
static_assert(RoundTrips::kDatagramBytes == sizeof(tandem_LinkedState) + kRtpsBytes);

using Datagram = std::array<char, RoundTrips::kDatagramBytes>;

sockaddr_in Loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

void SetReceiveTimeout(int socket, std::int64_t ns) {
  const timeval timeout{static_cast<time_t>(ns / 1'000'000'000),
                        static_cast<suseconds_t>(ns % 1'000'000'000 / 1000)};
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout);
}

timespec AsTimespec(std::int64_t ns) {
  return {static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
}

/// A participant with a writer and a reader of states with their links. It calls `on_state` on the
/// receive thread.
class StatePair {
 public:
  using OnState = void (*)(StatePair& self, const tandem_LinkedState& state, void* context);

  StatePair(OnState on_state, void* context) : on_state_(on_state), context_(context) {}

  Result<bool> Open(const RoundTripOptions& options, const char* to, const char* from) {
    RedirectCycloneLog();
    DdsOptions own;
    own.session = options.session;
    own.domain = options.domain;
    own.interface = std::string("lo");
    Result<Entity> domain = CreateDomain(own);
    if (!domain) return domain.error();
    domain_ = *std::move(domain);
    participant_ = Entity(dds_create_participant(options.domain, nullptr, nullptr));
    const auto topic = [this](const char* name) {
      return dds_create_topic(participant_.get(), &tandem_LinkedState_desc, name, nullptr, nullptr);
    };
    const Qos qos = MakeQos(Purpose::kMotion, "round_trip");
    writer_ = dds_create_writer(participant_.get(), topic(to), qos.get(), nullptr);
    const Listener listener(dds_create_listener(this));
    thread_ = ReceiveThreadOf(own);
    dds_lset_data_available(listener.get(), [](dds_entity_t reader, void* context) {
      auto* const self = static_cast<StatePair*>(context);
      if (OnReceiveThread(self->thread_)) self->TakeAll(reader);
    });
    reader_ = dds_create_reader(participant_.get(), topic(from), qos.get(), listener.get());
    if (writer_ < 0 || reader_ < 0) return Error{"cannot make a DDS writer and reader"};
    dds_instance_handle_t instance = 0;
    const tandem_LinkedState key{};
    dds_register_instance(writer_, &instance, &key);
    return true;
  }

  bool WaitForMatch(std::int64_t until_ns) const {
    for (;;) {
      dds_publication_matched_status_t readers{};
      dds_subscription_matched_status_t writers{};
      dds_get_publication_matched_status(writer_, &readers);
      dds_get_subscription_matched_status(reader_, &writers);
      if (readers.current_count > 0 && writers.current_count > 0) return true;
      if (MonotonicNowNs() > until_ns) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  void Write(const tandem_LinkedState& state) const { dds_write(writer_, &state); }

 private:
  void TakeAll(dds_entity_t reader) {
    void* samples[1] = {&taken_};  // NOLINT(modernize-avoid-c-arrays): dds_take's
    dds_sample_info_t info{};
    while (dds_take(reader, samples, &info, 1, 1) > 0) {
      if (info.valid_data) on_state_(*this, taken_, context_);
    }
  }

  const OnState on_state_;
  void* const context_;
  const char* thread_ = nullptr;
  Entity domain_;
  Entity participant_;  // destroyed before its domain
  dds_entity_t writer_ = 0;
  dds_entity_t reader_ = 0;
  tandem_LinkedState taken_{};
};

/// The requester's round trips over DDS and over UDP.
class Requester {
 public:
  Requester() { sem_init(&answered_, 0, 0); }
  ~Requester() { sem_destroy(&answered_); }
  Requester(const Requester&) = delete;
  Requester& operator=(const Requester&) = delete;

  static void OnAnswer(StatePair& /*pair*/, const tandem_LinkedState& state, void* context) {
    auto& self = *static_cast<Requester*>(context);
    self.arrival_ns_.store(MonotonicNowNs());
    self.seq_.store(state.state.seq);
    sem_post(&self.answered_);
  }

  /// Returns the round trip's time; negative: no answer.
  std::int64_t OverDds(const StatePair& pair, std::uint32_t seq) {
    tandem_LinkedState state{};
    state.state.seq = seq;
    const std::int64_t sent_ns = MonotonicNowNs();
    pair.Write(state);
    const timespec deadline = AsTimespec(sent_ns + kAnswerNs);
    while (seq_.load() != seq) {
      if (sem_clockwait(&answered_, CLOCK_MONOTONIC, &deadline) != 0 && errno == ETIMEDOUT) {
        return -1;
      }
    }
    while (sem_trywait(&answered_) == 0) {
    }
    return arrival_ns_.load() - sent_ns;
  }

  static std::int64_t OverUdp(int socket, std::uint32_t seq) {
    Datagram packet{};
    std::memcpy(packet.data(), &seq, sizeof seq);
    const std::int64_t sent_ns = MonotonicNowNs();
    if (send(socket, packet.data(), packet.size(), 0) < 0) return -1;
    for (;;) {
      if (recv(socket, packet.data(), packet.size(), 0) < 0) return -1;
      const std::int64_t arrival_ns = MonotonicNowNs();
      std::uint32_t answered = 0;
      std::memcpy(&answered, packet.data(), sizeof answered);
      if (answered == seq) return arrival_ns - sent_ns;
    }
  }

 private:
  sem_t answered_{};
  std::atomic<std::uint32_t> seq_ = 0;
  std::atomic<std::int64_t> arrival_ns_ = 0;
};

RoundTrips Ask(int socket, const StatePair& pair, Requester& requester, double seconds) {
  RoundTrips trips;
  trips.fifo = EnterRealtime(kAskerPriority).fifo;
  const auto count = [](std::int64_t ns, Histogram& taken, std::uint64_t& lost) {
    if (ns < 0) {
      ++lost;
    } else {
      taken.Add(ns);
    }
  };
  const auto turns = static_cast<std::uint32_t>(1000 * seconds) + kWarmUp;
  std::int64_t next_ns = MonotonicNowNs();
  for (std::uint32_t turn = 1; turn <= turns; ++turn) {
    next_ns = std::max(next_ns + kPeriodNs, MonotonicNowNs());
    const timespec deadline = AsTimespec(next_ns);
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr);
    std::int64_t udp_ns = 0;
    std::int64_t dds_ns = 0;
    // the second of a turn finds the processors awake, so the two take turns
    if (turn % 2 == 0) udp_ns = Requester::OverUdp(socket, turn);
    dds_ns = requester.OverDds(pair, turn);
    if (turn % 2 != 0) udp_ns = Requester::OverUdp(socket, turn);
    if (turn <= kWarmUp) continue;
    count(udp_ns, trips.udp, trips.udp_lost);
    count(dds_ns, trips.dds, trips.dds_lost);
  }
  return trips;
}

}  // namespace

Result<RoundTripMeter> RoundTripMeter::Open() {
  RoundTripMeter meter;
  meter.socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = Loopback(0);
  socklen_t size = sizeof address;
  if (meter.socket_ < 0 ||
      bind(meter.socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      getsockname(meter.socket_, reinterpret_cast<sockaddr*>(&address), &size) != 0) {
    return Error{std::string("cannot open a UDP socket: ") + std::strerror(errno)};
  }
  meter.port_ = ntohs(address.sin_port);
  return meter;
}

RoundTripMeter::RoundTripMeter(RoundTripMeter&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), port_(other.port_) {}

RoundTripMeter::~RoundTripMeter() {
  if (socket_ >= 0) close(socket_);
}

Result<bool> RoundTripMeter::MeetEcho() const {
  SetReceiveTimeout(socket_, kMeetNs);
  Datagram hello{};
  sockaddr_in echo{};
  socklen_t size = sizeof echo;
  if (recvfrom(socket_, hello.data(), hello.size(), 0, reinterpret_cast<sockaddr*>(&echo), &size) <
          0 ||
      connect(socket_, reinterpret_cast<sockaddr*>(&echo), sizeof echo) != 0) {
    return Error{"the echo process did not come"};
  }
  SetReceiveTimeout(socket_, kAnswerNs);
  return true;
}

Result<RoundTrips> RoundTripMeter::Measure(const RoundTripOptions& options) {
  Requester requester;
  StatePair pair(&Requester::OnAnswer, &requester);
  if (const Result<bool> open = pair.Open(options, "ping", "pong"); !open) return open.error();
  if (const Result<bool> met = MeetEcho(); !met) return met.error();
  if (!pair.WaitForMatch(MonotonicNowNs() + kMeetNs)) return Error{"DDS did not find the echo"};
  RoundTrips trips;
  // on a separate thread, so that only the measurement is real-time
  std::thread([&] {
    trips = Ask(socket_, pair, requester, options.seconds);
  }).join();
  return trips;
}

Result<bool> EchoRoundTrips(const RoundTripOptions& options, std::uint16_t port,
                            const std::atomic<bool>& stop) {
  StatePair pair(
      [](StatePair& self, const tandem_LinkedState& state, void*) {
        self.Write(state);
      },
      nullptr);
  if (const Result<bool> open = pair.Open(options, "pong", "ping"); !open) return open.error();
  const int echo = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const sockaddr_in requester = Loopback(port);
  if (echo < 0 ||
      connect(echo, reinterpret_cast<const sockaddr*>(&requester), sizeof requester) != 0) {
    return Error{std::string("cannot open a UDP socket: ") + std::strerror(errno)};
  }
  SetReceiveTimeout(echo, 100'000'000);
  Datagram packet{};
  send(echo, packet.data(), packet.size(), 0);
  EnterRealtime(ReceivePriority());  // the receive thread's priority, for the UDP echo
  while (!stop.load()) {
    const ssize_t size = recv(echo, packet.data(), packet.size(), 0);
    if (size > 0) send(echo, packet.data(), static_cast<std::size_t>(size), 0);
  }
  close(echo);
  return true;
}

}  // namespace tandem
