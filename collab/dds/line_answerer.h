#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "collab/dds/line_messages.h"

namespace tandem {

/// The answerer's side of line_messages.h, without sockets and clocks: it is given packets and the
/// time, and what it wants to send goes to `send`. One thread.
///
/// It cannot be made to flood a third machine: nothing is sent at a rate before the asker has given
/// back a token that went to its address. Then samples go out only while the asker's own come in,
/// no more than four for each that came and kAheadS seconds' worth, and not after kSilenceNs
/// without one. At most kMostStreams run at a time, one of each address.
class LineAnswerer {
 public:
  static constexpr std::size_t kMostStreams = 2;
  static constexpr std::int64_t kSilenceNs = 3'000'000'000;
  static constexpr std::int64_t kKeptNs = 30'000'000'000;  // after the last packet of the asker
  static constexpr double kAheadS = 3;

  struct Address {
    std::uint32_t host = 0;
    std::uint16_t port = 0;
    friend auto operator<=>(const Address&, const Address&) = default;
  };
  using Send = std::function<void(const Address& to, std::span<const std::byte> packet)>;

  /// `secret`: random, what tokens are made with.
  explicit LineAnswerer(const std::array<std::uint8_t, 32>& secret) : secret_(secret) {}

  /// A packet that came at `arrival_ns`. `may_answer`: whether a stranger may be answered now.
  /// True: it is of this protocol, whatever became of it.
  bool Take(std::span<const std::byte> packet, const Address& from, std::int64_t arrival_ns,
            const std::function<bool()>& may_answer, const Send& send);
  /// Sends what is due, and forgets who has gone.
  void SendDue(std::int64_t now_ns, const Send& send);
  /// When SendDue() has something to do again.
  std::optional<std::int64_t> NextDueNs() const;
  std::size_t streams() const noexcept { return streams_.size(); }

 private:
  struct Stream {
    Address to;
    std::uint64_t nonce = 0;
    LineTerms terms;
    std::vector<std::int64_t> arrivals_ns;  // of the asker's samples, minus their sending
    std::int64_t begin_ns = 0;
    std::int64_t heard_ns = 0;         // a packet of the asker
    std::int64_t sample_heard_ns = 0;  // a sample of the asker
    std::uint32_t sent = 0;
    std::uint32_t heard = 0;  // samples
    std::uint32_t fetches = 0;
    std::int64_t echo_ns = 0;  // the newest sending of a sample that is here
    std::int64_t echo_arrival_ns = 0;

    std::int64_t DueNs() const;
    bool MaySend(std::int64_t now_ns) const;
  };

  LineToken TokenOf(const Address& to, std::uint64_t nonce, const LineTerms& terms) const;
  Stream* Find(const Address& from, std::uint64_t nonce);
  void Answer(const LineAsk& ask, const Address& from, std::int64_t now_ns, const Send& send);
  static void TakeSample(const LineSample& sample, std::int64_t arrival_ns, Stream& stream);
  static void GiveArrivals(const LineArrivals& fetch, Stream& stream, const Send& send);

  std::array<std::uint8_t, 32> secret_;
  std::vector<Stream> streams_;
};

}  // namespace tandem
