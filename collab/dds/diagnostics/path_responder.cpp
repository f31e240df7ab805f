#include "collab/dds/diagnostics/path_responder.h"

#include <algorithm>

#include "collab/trace/path_record.h"
#include "engine/base/files/sha256.h"
#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr std::int64_t kStartDelayNs = 20'000'000;
constexpr std::uint32_t kMostCatchUp = 20;  // samples at once, after a pause of this program

}  // namespace

std::int64_t PathResponder::Stream::DueNs() const {
  return begin_ns + kSecondNs * sent / terms.rate_hz;
}

bool PathResponder::Stream::MaySend(std::int64_t now_ns) const {
  const double most = 4.0 * received + kAheadS * terms.rate_hz;
  return sent < terms.samples && now_ns - sample_heard_ns < kSilenceNs && sent < most;
}

PathToken PathResponder::TokenOf(const Address& to, std::uint64_t nonce,
                                 const PathTerms& terms) const {
  struct TokenContent {
    std::array<std::uint8_t, 32> secret;
    std::uint64_t nonce;
    PathTerms terms;
    std::uint32_t host;
    std::uint32_t port;
    std::uint32_t unused;
  };
  static_assert(sizeof(TokenContent) == 64);
  const TokenContent content{secret_, nonce, terms, to.host, to.port, 0};
  std::array<char, sizeof content> bytes;
  std::memcpy(bytes.data(), &content, sizeof content);
  const Sha256 digest = Sha256Of(bytes);
  PathToken token;
  std::copy_n(digest.begin(), token.size(), token.begin());
  return token;
}

PathResponder::Stream* PathResponder::Find(const Address& from, std::uint64_t nonce) {
  const auto it = std::ranges::find_if(streams_, [&](const Stream& stream) {
    return stream.to == from && stream.nonce == nonce;
  });
  return it == streams_.end() ? nullptr : &*it;
}

void PathResponder::Answer(const PathRequest& ask, const Address& from, std::int64_t now_ns,
                           const Send& send) {
  PathRequest answer = ask;
  answer.head.version = kPathVersion;
  answer.token = {};
  Stream* stream = Find(from, ask.head.nonce);
  const bool full = std::ranges::any_of(streams_,
                                        [&](const Stream& other) {
                                          return other.to.host == from.host;
                                        }) ||
                    streams_.size() >= kMostStreams;
  if (ask.head.version != kPathVersion) {
    answer.head.word = PathMessageKind::kRefuse;
    answer.refusal = PathRefusal::kVersion;
  } else if (!Permitted(ask.terms)) {
    answer.head.word = PathMessageKind::kRefuse;
    answer.refusal = PathRefusal::kTerms;
  } else if (stream == nullptr && full) {
    answer.head.word = PathMessageKind::kRefuse;
    answer.refusal = PathRefusal::kBusy;
  } else if (ask.head.word == PathMessageKind::kAsk) {
    answer.head.word = PathMessageKind::kOffer;
    answer.token = TokenOf(from, ask.head.nonce, ask.terms);
  } else {
    if (ask.token != TokenOf(from, ask.head.nonce, ask.terms)) return;
    if (stream == nullptr) {  // else the first answer was lost
      Stream& begun = streams_.emplace_back();
      begun.to = from;
      begun.nonce = ask.head.nonce;
      begun.terms = ask.terms;
      begun.arrivals_ns.assign(ask.terms.samples, PathRecord::kNever);
      begun.begin_ns = now_ns + kStartDelayNs;
      begun.received_ns = begun.sample_heard_ns = now_ns;
    }
    answer.head.word = PathMessageKind::kBegun;
  }
  std::array<std::byte, sizeof answer> room;
  send(from, PacketOf(answer, sizeof answer, room));
}

void PathResponder::TakeSample(const PathSample& sample, std::int64_t arrival_ns, Stream& stream) {
  if (sample.seq >= stream.arrivals_ns.size()) return;
  std::int64_t& place = stream.arrivals_ns[sample.seq];
  stream.sample_heard_ns = arrival_ns;
  if (place != PathRecord::kNever) return;  // it has come before
  place = arrival_ns - sample.sent_ns;
  if (place == PathRecord::kNever) place = 0;
  ++stream.received;
  if (sample.sent_ns <= stream.echo_ns) return;
  stream.echo_ns = sample.sent_ns;
  stream.echo_arrival_ns = arrival_ns;
}

void PathResponder::GiveArrivals(const PathArrivals& fetch, Stream& stream, const Send& send) {
  const auto all = static_cast<std::uint32_t>(stream.arrivals_ns.size());
  // each packet may be asked for several times, because packets are lost
  if (fetch.first >= all || ++stream.fetches > 16 * (all / kArrivalsInPacket + 1)) return;
  PathArrivals answer;
  answer.head = fetch.head;
  answer.head.word = PathMessageKind::kArrivals;
  answer.first = fetch.first;
  answer.count = std::min<std::uint32_t>(kArrivalsInPacket, all - fetch.first);
  std::copy_n(stream.arrivals_ns.begin() + fetch.first, answer.count, answer.ns.begin());
  std::array<std::byte, kPathFetchBytes> room;
  send(stream.to, PacketOf(answer, kPathFetchBytes, room));
}

bool PathResponder::Take(std::span<const std::byte> packet, const Address& from,
                         std::int64_t arrival_ns, const std::function<bool()>& may_answer,
                         const Send& send) {
  const std::optional<PathHeader> head = PathHeaderIn(packet);
  if (!head) return false;
  if (head->word == PathMessageKind::kAsk || head->word == PathMessageKind::kStart) {
    const std::optional<PathRequest> ask = MessageIn<PathRequest>(packet);
    // an ask that is shorter than the answers might get more bytes back than it has
    if (ask && packet.size() >= kPathRequestBytes && may_answer()) {
      Answer(*ask, from, arrival_ns, send);
    }
    return true;
  }
  Stream* const stream = Find(from, head->nonce);
  if (stream == nullptr) return true;
  stream->received_ns = arrival_ns;
  if (head->word == PathMessageKind::kSample) {
    const std::optional<PathSample> sample = MessageIn<PathSample>(packet);
    if (sample && packet.size() >= stream->terms.bytes) TakeSample(*sample, arrival_ns, *stream);
  } else if (head->word == PathMessageKind::kFetch && packet.size() >= kPathFetchBytes) {
    if (const auto fetch = MessageIn<PathArrivals>(packet)) GiveArrivals(*fetch, *stream, send);
  } else if (head->word == PathMessageKind::kDone) {
    std::erase_if(streams_, [&](const Stream& other) {
      return &other == stream;
    });
  }
  return true;
}

void PathResponder::SendDue(std::int64_t now_ns, const Send& send) {
  std::array<std::byte, kMostLineBytes> room;
  for (Stream& stream : streams_) {
    for (std::uint32_t i = 0; i < kMostCatchUp && stream.DueNs() <= now_ns; ++i) {
      if (!stream.MaySend(now_ns)) {
        stream.sent =
            stream.terms.samples;  // for good: the requester has gone, or receives too little
        break;
      }
      PathSample sample;
      sample.head.word = PathMessageKind::kSample;
      sample.head.nonce = stream.nonce;
      sample.seq = stream.sent++;
      sample.received = stream.received;
      sample.sent_ns = now_ns;
      sample.echo_ns = stream.echo_ns;
      sample.held_ns = stream.echo_ns == 0 ? 0 : now_ns - stream.echo_arrival_ns;
      send(stream.to, PacketOf(sample, stream.terms.bytes, room));
    }
  }
  std::erase_if(streams_, [now_ns](const Stream& stream) {
    return now_ns - stream.received_ns > kKeptNs;
  });
}

std::optional<std::int64_t> PathResponder::NextDueNs() const {
  std::optional<std::int64_t> next;
  for (const Stream& stream : streams_) {
    if (stream.sent < stream.terms.samples) {
      next = std::min(next.value_or(stream.DueNs()), stream.DueNs());
    }
  }
  return next;
}

}  // namespace tandem
