#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "collab/dds/diagnostics/path_messages.h"

namespace tandem {

/// The responder's side of path_messages.h, without sockets and clocks. It is given packets and the
/// time, and hands the packets it wants to send to `send`. One thread.
///
/// It cannot be made to flood a third machine. It sends nothing at a rate before the requester has
/// given back a token that went to its address. Then it sends samples only while the requester's
/// own come in. It sends at most four for each that came, plus kAheadS seconds' worth, and none
/// after kSilenceNs without one. At most kMostStreams run at a time, one for each host.
class PathResponder {
 public:
  static constexpr std::size_t kMostStreams = 2;
  static constexpr std::int64_t kSilenceNs = 3'000'000'000;
  static constexpr std::int64_t kKeptNs = 30'000'000'000;  // after the requester's last packet
  static constexpr double kAheadS = 3;

  struct Address {
    std::uint32_t host = 0;
    std::uint16_t port = 0;
    friend auto operator<=>(const Address&, const Address&) = default;
  };
  using Send = std::function<void(const Address& to, std::span<const std::byte> packet)>;

  /// `secret` is random; tokens are made with it.
  explicit PathResponder(const std::array<std::uint8_t, 32>& secret) : secret_(secret) {}

  /// Takes a packet that came at `arrival_ns`. `may_answer` says whether a stranger may be answered
  /// at this time. Returns true if the packet is of this protocol, whatever became of it.
  bool Take(std::span<const std::byte> packet, const Address& from, std::int64_t arrival_ns,
            const std::function<bool()>& may_answer, const Send& send);
  /// Sends the samples that are due, and forgets requesters that have gone.
  void SendDue(std::int64_t now_ns, const Send& send);
  /// Returns when SendDue() has something to do again.
  std::optional<std::int64_t> NextDueNs() const;
  std::size_t streams() const noexcept { return streams_.size(); }

 private:
  struct Stream {
    Address to;
    std::uint64_t nonce = 0;
    PathTerms terms;
    std::vector<std::int64_t> arrivals_ns;  // the requester's samples, arrival minus sending
    std::int64_t begin_ns = 0;
    std::int64_t received_ns = 0;      // arrival of the requester's last packet
    std::int64_t sample_heard_ns = 0;  // arrival of the requester's last sample
    std::uint32_t sent = 0;
    std::uint32_t received = 0;  // number of the requester's samples
    std::uint32_t fetches = 0;
    std::int64_t echo_ns = 0;  // newest sending time of a sample that has arrived
    std::int64_t echo_arrival_ns = 0;

    std::int64_t DueNs() const;
    bool MaySend(std::int64_t now_ns) const;
  };

  PathToken TokenOf(const Address& to, std::uint64_t nonce, const PathTerms& terms) const;
  Stream* Find(const Address& from, std::uint64_t nonce);
  void Answer(const PathRequest& ask, const Address& from, std::int64_t now_ns, const Send& send);
  static void TakeSample(const PathSample& sample, std::int64_t arrival_ns, Stream& stream);
  static void GiveArrivals(const PathArrivals& fetch, Stream& stream, const Send& send);

  std::array<std::uint8_t, 32> secret_;
  std::vector<Stream> streams_;
};

}  // namespace tandem
