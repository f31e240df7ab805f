#include "collab/dds/diagnostics/path_recorder.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <random>
#include <thread>
#include <utility>

#include <arpa/inet.h>
#include <netdb.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/diagnostics/udp_stamps.h"
#include "engine/realtime/clock.h"
#include "engine/realtime/realtime_setup.h"

namespace tandem {

namespace {

constexpr int kRecorderPriority = 30;
constexpr int kTries = 5;
constexpr std::int64_t kAnswerWithinNs = 1'500'000'000;
constexpr std::int64_t kStragglersNs = 2'500'000'000;  // after the last sample was sent
constexpr std::int64_t kFetchAgainNs = 1'000'000'000;
constexpr std::int64_t kFetchEveryNs = 2'000'000;
constexpr int kFetchRounds = 20;

const char* ReasonText(PathRefusal refusal) {
  switch (refusal) {
    case PathRefusal::kTerms:
      return "refuses so long or so fast a stream: ask for less with --seconds and --hz";
    case PathRefusal::kBusy:
      return "records with others already: try again later";
    case PathRefusal::kVersion:
      break;
  }
  return "has another version of Tandem: both ends need the same";
}

class Recorder {
 public:
  Recorder(const PathTerms& terms, const std::atomic<bool>& stop) : terms_(terms), stop_(stop) {
    std::random_device random;
    nonce_ = (static_cast<std::uint64_t>(random()) << 32U) | random();
    line_.record.rate_hz = terms.rate_hz;
    line_.record.there_ns.assign(terms.samples, PathRecord::kNever);
    line_.record.back_ns.assign(terms.samples, PathRecord::kNever);
    line_.loop_age_ns.reserve(terms.samples);
    line_.held_ns.reserve(terms.samples);
  }
  ~Recorder() {
    if (socket_ >= 0) close(socket_);
  }
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  std::optional<Error> Open(const std::string& host, std::uint16_t port) {
    addrinfo hints{};
    hints.ai_family = AF_INET;
    hints.ai_socktype = SOCK_DGRAM;
    addrinfo* found = nullptr;
    host_ = host;
    if (getaddrinfo(host.c_str(), nullptr, &hints, &found) != 0) {
      return Error{host + ": no IPv4 address is known for that name"};
    }
    sockaddr_in to = *reinterpret_cast<const sockaddr_in*>(found->ai_addr);
    freeaddrinfo(found);
    to.sin_port = htons(port);
    std::array<char, INET_ADDRSTRLEN> text{};
    inet_ntop(AF_INET, &to.sin_addr, text.data(), text.size());
    line_.address = text.data();
    socket_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (socket_ < 0 || connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
      return Error{host + ": " + std::strerror(errno)};
    }
    StampArrivals(socket_);
    return std::nullopt;
  }

  /// Agrees with the other end before any samples are sent.
  std::optional<Error> Agree() {
    PathRequest ask;
    ask.head.nonce = nonce_;
    ask.terms = terms_;
    const Result<PathRequest> offer = Ask(ask, PathMessageKind::kOffer);
    if (!offer) return offer.error();
    ask.head.word = PathMessageKind::kStart;
    ask.token = offer->token;
    const Result<PathRequest> begun = Ask(ask, PathMessageKind::kBegun);
    return begun ? std::nullopt : std::optional(begun.error());
  }

  void Record() {
    EnterRealtime(kRecorderPriority);
    prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
    const std::int64_t begin_ns = MonotonicNowNs() + 20'000'000;
    std::uint32_t sent = 0;
    const auto due_ns = [&] {
      return begin_ns + std::int64_t{1'000'000'000} * sent / terms_.rate_hz;
    };
    while (sent < terms_.samples && !stop_.load()) {
      WaitForPacket(socket_, due_ns());
      TakeAll();
      while (sent < terms_.samples && due_ns() <= MonotonicNowNs()) SendSample(sent++);
    }
    // own samples still under way may be as late as the latest so far, and later
    const std::int64_t sent_ns = MonotonicNowNs();
    const std::int64_t end_ns = sent_ns + kStragglersNs;
    const auto all_here = [&] {
      const auto oldest = std::ranges::max_element(line_.loop_age_ns);
      const std::int64_t age_ns = oldest == line_.loop_age_ns.end() ? kStragglersNs : *oldest;
      return received_ == terms_.samples && MonotonicNowNs() > sent_ns + 2 * age_ns + 200'000'000;
    };
    while (MonotonicNowNs() < end_ns && !all_here() && !stop_.load()) {
      WaitForPacket(socket_, std::min(end_ns, MonotonicNowNs() + 100'000'000));
      TakeAll();
    }
  }

  /// Fetches the times at which our samples arrived there.
  std::optional<Error> Fetch() {
    const std::size_t packets = (terms_.samples + kArrivalsInPacket - 1) / kArrivalsInPacket;
    fetched_.assign(packets, false);
    std::array<std::byte, kPathFetchBytes> room;
    for (int round = 0; round < kFetchRounds && left_ > 0; ++round) {
      for (std::size_t i = 0; i < packets && !stop_.load(); ++i) {
        if (fetched_[i]) continue;
        PathArrivals fetch;
        fetch.head.word = PathMessageKind::kFetch;
        fetch.head.nonce = nonce_;
        fetch.first = static_cast<std::uint32_t>(i * kArrivalsInPacket);
        const auto packet = PacketOf(fetch, kPathFetchBytes, room);
        send(socket_, packet.data(), packet.size(), 0);
        WaitFor(kFetchEveryNs);
      }
      for (int i = 0; i < 20 && left_ > 0 && !stop_.load(); ++i) WaitFor(kFetchAgainNs / 20);
    }
    if (stop_.load()) return Error{"stopped: there is no trace"};
    if (left_ > 0) return Error{host_ + " answers no longer: there is no trace"};
    PathRequest done;
    done.head.word = PathMessageKind::kDone;
    done.head.nonce = nonce_;
    const auto packet = PacketOf(done, kPathRequestBytes, room);
    send(socket_, packet.data(), packet.size(), 0);
    return std::nullopt;
  }

  RecordedPath Take() { return std::move(line_); }

 private:
  Result<PathRequest> Ask(const PathRequest& ask, PathMessageKind wanted) {
    std::array<std::byte, kPathRequestBytes> room;
    for (int i = 0; i < kTries && !stop_.load(); ++i) {
      const auto packet = PacketOf(ask, kPathRequestBytes, room);
      send(socket_, packet.data(), packet.size(), 0);
      const std::int64_t until_ns = MonotonicNowNs() + kAnswerWithinNs;
      while (MonotonicNowNs() < until_ns && !stop_.load()) {
        WaitForPacket(socket_, std::min(until_ns, MonotonicNowNs() + 100'000'000));
        const std::optional<StampedPacket> got = ReceiveStamped(socket_, packet_);
        if (!got) continue;
        const auto answer = MessageIn<PathRequest>(std::span(packet_).first(got->bytes));
        if (!answer || !IsOurs(answer->head)) continue;
        if (answer->head.word == PathMessageKind::kRefuse) {
          return Error{host_ + " " + ReasonText(answer->refusal)};
        }
        if (answer->head.word == wanted) return *answer;
      }
    }
    return Error{host_ + " does not answer: run 'tandem doctor --answer' of this version there"};
  }

  bool IsOurs(const PathHeader& head) const {
    return head.mark == PathHeader{}.mark && head.nonce == nonce_;
  }

  void WaitFor(std::int64_t ns) {
    const std::int64_t until_ns = MonotonicNowNs() + ns;
    do {
      WaitForPacket(socket_, until_ns);
      TakeAll();
    } while (MonotonicNowNs() < until_ns && left_ > 0);
  }

  void SendSample(std::uint32_t seq) {
    PathSample sample;
    sample.head.word = PathMessageKind::kSample;
    sample.head.nonce = nonce_;
    sample.seq = seq;
    sample.received = received_;
    std::array<std::byte, kMostLineBytes> room;
    sample.sent_ns = MonotonicNowNs();
    const auto packet = PacketOf(sample, terms_.bytes, room);
    send(socket_, packet.data(), packet.size(), 0);
  }

  void TakeAll() {
    while (const std::optional<StampedPacket> got = ReceiveStamped(socket_, packet_)) {
      const std::span<const std::byte> packet = std::span(packet_).first(got->bytes);
      const std::optional<PathHeader> head = PathHeaderIn(packet);
      if (!head || !IsOurs(*head)) continue;
      if (head->word == PathMessageKind::kSample) {
        if (const auto sample = MessageIn<PathSample>(packet)) TakeSample(*sample, got->arrival_ns);
      } else if (head->word == PathMessageKind::kArrivals) {
        if (const auto arrivals = MessageIn<PathArrivals>(packet)) TakeArrivals(*arrivals);
      }
    }
  }

  void TakeSample(const PathSample& sample, std::int64_t arrival_ns) {
    if (sample.seq >= line_.record.back_ns.size()) return;
    std::int64_t& place = line_.record.back_ns[sample.seq];
    if (place != PathRecord::kNever) {
      ++line_.twice;
      return;
    }
    place = arrival_ns - sample.sent_ns;
    ++received_;
    if (sample.echo_ns == 0) return;
    line_.loop_age_ns.push_back(arrival_ns - sample.echo_ns);
    line_.held_ns.push_back(sample.held_ns);
  }

  void TakeArrivals(const PathArrivals& arrivals) {
    const std::size_t number = arrivals.first / kArrivalsInPacket;
    if (number >= fetched_.size() || arrivals.first % kArrivalsInPacket != 0) return;
    if (fetched_[number]) return;
    const std::size_t count =
        std::min<std::size_t>(kArrivalsInPacket, terms_.samples - arrivals.first);
    if (arrivals.count != count) return;
    std::copy_n(arrivals.ns.begin(), count, line_.record.there_ns.begin() + arrivals.first);
    fetched_[number] = true;
    left_ -= count;
  }

  PathTerms terms_;
  const std::atomic<bool>& stop_;
  std::string host_;
  std::uint64_t nonce_ = 0;
  int socket_ = -1;
  std::array<std::byte, 2048> packet_{};
  std::uint32_t received_ = 0;  // number of the other end's samples
  std::vector<bool> fetched_;
  std::size_t left_ = terms_.samples;  // number of own samples whose arrival is not known yet
  RecordedPath line_;
};

}  // namespace

Result<RecordedPath> RecordPath(const std::string& host, std::uint16_t port, const PathTerms& terms,
                                const std::atomic<bool>& stop) {
  if (!Permitted(terms)) return Error{"no answerer grants such a stream"};
  Recorder recorder(terms, stop);
  if (const auto failed = recorder.Open(host, port)) return *failed;
  if (const auto failed = recorder.Agree()) return *failed;
  // on a separate thread, so that only the recording is real-time
  std::thread([&recorder] {
    recorder.Record();
  }).join();
  if (const auto failed = recorder.Fetch()) return *failed;
  return recorder.Take();
}

}  // namespace tandem
