#include "collab/dds/diagnostics/line_answerer.h"

#include <algorithm>

#include "collab/trace/line_record.h"
#include "collab/transfer/digest.h"
#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr std::int64_t kStartDelayNs = 20'000'000;
constexpr std::uint32_t kMostCatchUp = 20;  // samples at once, after a pause of this program

}  // namespace

std::int64_t LineAnswerer::Stream::DueNs() const {
  return begin_ns + kSecondNs * sent / terms.rate_hz;
}

bool LineAnswerer::Stream::MaySend(std::int64_t now_ns) const {
  const double most = 4.0 * heard + kAheadS * terms.rate_hz;
  return sent < terms.samples && now_ns - sample_heard_ns < kSilenceNs && sent < most;
}

LineToken LineAnswerer::TokenOf(const Address& to, std::uint64_t nonce,
                                const LineTerms& terms) const {
  struct Said {
    std::array<std::uint8_t, 32> secret;
    std::uint64_t nonce;
    LineTerms terms;
    std::uint32_t host;
    std::uint32_t port;
    std::uint32_t unused;
  };
  static_assert(sizeof(Said) == 64);
  const Said said{secret_, nonce, terms, to.host, to.port, 0};
  std::array<char, sizeof said> bytes;
  std::memcpy(bytes.data(), &said, sizeof said);
  const FileDigest digest = FileDigestOf(bytes);
  LineToken token;
  std::copy_n(digest.begin(), token.size(), token.begin());
  return token;
}

LineAnswerer::Stream* LineAnswerer::Find(const Address& from, std::uint64_t nonce) {
  const auto it = std::ranges::find_if(streams_, [&](const Stream& stream) {
    return stream.to == from && stream.nonce == nonce;
  });
  return it == streams_.end() ? nullptr : &*it;
}

void LineAnswerer::Answer(const LineAsk& ask, const Address& from, std::int64_t now_ns,
                          const Send& send) {
  LineAsk answer = ask;
  answer.head.version = kLineVersion;
  answer.token = {};
  Stream* stream = Find(from, ask.head.nonce);
  const bool full = std::ranges::any_of(streams_,
                                        [&](const Stream& other) {
                                          return other.to.host == from.host;
                                        }) ||
                    streams_.size() >= kMostStreams;
  if (ask.head.version != kLineVersion) {
    answer.head.word = LineWord::kRefuse;
    answer.refusal = LineRefusal::kVersion;
  } else if (!Permitted(ask.terms)) {
    answer.head.word = LineWord::kRefuse;
    answer.refusal = LineRefusal::kTerms;
  } else if (stream == nullptr && full) {
    answer.head.word = LineWord::kRefuse;
    answer.refusal = LineRefusal::kBusy;
  } else if (ask.head.word == LineWord::kAsk) {
    answer.head.word = LineWord::kOffer;
    answer.token = TokenOf(from, ask.head.nonce, ask.terms);
  } else {
    if (ask.token != TokenOf(from, ask.head.nonce, ask.terms)) return;
    if (stream == nullptr) {  // else the first answer was lost
      Stream& begun = streams_.emplace_back();
      begun.to = from;
      begun.nonce = ask.head.nonce;
      begun.terms = ask.terms;
      begun.arrivals_ns.assign(ask.terms.samples, LineRecord::kNever);
      begun.begin_ns = now_ns + kStartDelayNs;
      begun.heard_ns = begun.sample_heard_ns = now_ns;
    }
    answer.head.word = LineWord::kBegun;
  }
  std::array<std::byte, sizeof answer> room;
  send(from, PacketOf(answer, sizeof answer, room));
}

void LineAnswerer::TakeSample(const LineSample& sample, std::int64_t arrival_ns, Stream& stream) {
  if (sample.seq >= stream.arrivals_ns.size()) return;
  std::int64_t& place = stream.arrivals_ns[sample.seq];
  stream.sample_heard_ns = arrival_ns;
  if (place != LineRecord::kNever) return;  // it has come before
  place = arrival_ns - sample.sent_ns;
  if (place == LineRecord::kNever) place = 0;
  ++stream.heard;
  if (sample.sent_ns <= stream.echo_ns) return;
  stream.echo_ns = sample.sent_ns;
  stream.echo_arrival_ns = arrival_ns;
}

void LineAnswerer::GiveArrivals(const LineArrivals& fetch, Stream& stream, const Send& send) {
  const auto all = static_cast<std::uint32_t>(stream.arrivals_ns.size());
  // each packet may be asked for several times, because packets are lost
  if (fetch.first >= all || ++stream.fetches > 16 * (all / kArrivalsInPacket + 1)) return;
  LineArrivals answer;
  answer.head = fetch.head;
  answer.head.word = LineWord::kArrivals;
  answer.first = fetch.first;
  answer.count = std::min<std::uint32_t>(kArrivalsInPacket, all - fetch.first);
  std::copy_n(stream.arrivals_ns.begin() + fetch.first, answer.count, answer.ns.begin());
  std::array<std::byte, kLineFetchBytes> room;
  send(stream.to, PacketOf(answer, kLineFetchBytes, room));
}

bool LineAnswerer::Take(std::span<const std::byte> packet, const Address& from,
                        std::int64_t arrival_ns, const std::function<bool()>& may_answer,
                        const Send& send) {
  const std::optional<LineHead> head = LineHeadIn(packet);
  if (!head) return false;
  if (head->word == LineWord::kAsk || head->word == LineWord::kStart) {
    const std::optional<LineAsk> ask = MessageIn<LineAsk>(packet);
    // an ask that is shorter than the answers might get more bytes back than it has
    if (ask && packet.size() >= kLineAskBytes && may_answer()) {
      Answer(*ask, from, arrival_ns, send);
    }
    return true;
  }
  Stream* const stream = Find(from, head->nonce);
  if (stream == nullptr) return true;
  stream->heard_ns = arrival_ns;
  if (head->word == LineWord::kSample) {
    const std::optional<LineSample> sample = MessageIn<LineSample>(packet);
    if (sample && packet.size() >= stream->terms.bytes) TakeSample(*sample, arrival_ns, *stream);
  } else if (head->word == LineWord::kFetch && packet.size() >= kLineFetchBytes) {
    if (const auto fetch = MessageIn<LineArrivals>(packet)) GiveArrivals(*fetch, *stream, send);
  } else if (head->word == LineWord::kDone) {
    std::erase_if(streams_, [&](const Stream& other) {
      return &other == stream;
    });
  }
  return true;
}

void LineAnswerer::SendDue(std::int64_t now_ns, const Send& send) {
  std::array<std::byte, kMostLineBytes> room;
  for (Stream& stream : streams_) {
    for (std::uint32_t i = 0; i < kMostCatchUp && stream.DueNs() <= now_ns; ++i) {
      if (!stream.MaySend(now_ns)) {
        stream.sent = stream.terms.samples;  // for good: the asker has gone, or receives too little
        break;
      }
      LineSample sample;
      sample.head.word = LineWord::kSample;
      sample.head.nonce = stream.nonce;
      sample.seq = stream.sent++;
      sample.heard = stream.heard;
      sample.sent_ns = now_ns;
      sample.echo_ns = stream.echo_ns;
      sample.held_ns = stream.echo_ns == 0 ? 0 : now_ns - stream.echo_arrival_ns;
      send(stream.to, PacketOf(sample, stream.terms.bytes, room));
    }
  }
  std::erase_if(streams_, [now_ns](const Stream& stream) {
    return now_ns - stream.heard_ns > kKeptNs;
  });
}

std::optional<std::int64_t> LineAnswerer::NextDueNs() const {
  std::optional<std::int64_t> next;
  for (const Stream& stream : streams_) {
    if (stream.sent < stream.terms.samples) {
      next = std::min(next.value_or(stream.DueNs()), stream.DueNs());
    }
  }
  return next;
}

}  // namespace tandem
