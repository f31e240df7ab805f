#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

namespace tandem {

/// The messages between `tandem doctor --trace` and a responder, as UDP packets on the port of
/// probes. Numbers have this machine's byte order: both ends are little-endian, as is every machine
/// that Tandem is built for.
///
///   requester                      responder
///   kAsk  (terms)             ->
///                             <-   kOffer (token), or kRefuse: nothing is kept yet
///   kStart (terms, token)     ->   the token shows that the requester hears at its address
///                             <-   kBegun
///   kSample, paced            <->  kSample, paced: both as agreed, then silence
///   kFetch (first)            ->
///                             <-   kArrivals: when the requester's samples arrived
///   kDone                     ->
///
/// A packet of the responder is never larger than the requester's packet that it answers. Samples
/// are as large as the requester's own; the responder sends them only while the requester's keep
/// coming.
enum class PathMessageKind : std::uint32_t {
  kAsk = 1,
  kOffer,
  kStart,
  kBegun,
  kRefuse,
  kSample,
  kFetch,
  kArrivals,
  kDone
};

inline constexpr std::uint32_t kPathVersion = 1;
inline constexpr std::size_t kPathRequestBytes = 256;  // size of kAsk and kStart; no answer to them
                                                       // is larger
inline constexpr std::size_t kPathFetchBytes = 1200;   // size of kFetch and kArrivals
inline constexpr std::size_t kArrivalsInPacket = 128;

/// The agreed stream.
struct PathTerms {
  std::uint32_t rate_hz = 1000;
  std::uint32_t samples = 10'000;  // number for each end
  std::uint32_t bytes = 300;       // size of a sample's packet, UDP payload

  friend bool operator==(const PathTerms&, const PathTerms&) = default;
};

enum class PathRefusal : std::uint32_t { kTerms = 1, kBusy, kVersion };

using PathToken = std::array<std::uint8_t, 16>;

struct PathHeader {
  std::array<char, 8> mark{'t', 'd', '-', 'l', 'i', 'n', 'e', '1'};
  std::uint32_t version = kPathVersion;
  PathMessageKind word = PathMessageKind::kAsk;
  std::uint64_t nonce = 0;  // the requester's number of this record
};
struct PathRequest {  // kAsk, kOffer, kStart, kBegun, kRefuse, kDone
  PathHeader head;
  PathTerms terms;
  PathRefusal refusal = PathRefusal::kTerms;
  PathToken token{};
};
struct PathSample {
  PathHeader head;
  std::uint32_t seq = 0;
  std::uint32_t received = 0;  // number of all samples of the other end that have arrived
  std::int64_t sent_ns = 0;    // time of sending by the sender's clock
  std::int64_t echo_ns = 0;    // newest sent_ns of the other end that has arrived; 0: none
  std::int64_t held_ns = 0;    // time since that one arrived
};
struct PathArrivals {  // kFetch: `first` alone
  PathHeader head;
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  std::array<std::int64_t, kArrivalsInPacket> ns{};  // arrival minus sending, or PathRecord::kNever
};
static_assert(sizeof(PathHeader) == 24 && sizeof(PathRequest) == 56 && sizeof(PathSample) == 56);
static_assert(sizeof(PathRequest) <= kPathRequestBytes && sizeof(PathArrivals) <= kPathFetchBytes);

inline constexpr std::uint32_t kLeastLineBytes = sizeof(PathSample);
inline constexpr std::uint32_t kMostLineBytes = 1400;
inline constexpr std::uint32_t kMostLineHz = 1000;
inline constexpr std::uint32_t kMostLineSamples = 600'000;  // ten minutes at 1 kHz

inline bool Permitted(const PathTerms& terms) {
  return terms.rate_hz >= 1 && terms.rate_hz <= kMostLineHz && terms.samples >= 1 &&
         terms.samples <= kMostLineSamples && terms.bytes >= kLeastLineBytes &&
         terms.bytes <= kMostLineBytes;
}

/// Reads the packet as a message; nothing: it is too short.
template <typename Message>
std::optional<Message> MessageIn(std::span<const std::byte> packet) {
  if (packet.size() < sizeof(Message)) return std::nullopt;
  Message message;
  std::memcpy(&message, packet.data(), sizeof message);
  return message;
}

/// Returns the head of a packet of this protocol, of any version; nothing: it is of another
/// protocol.
inline std::optional<PathHeader> PathHeaderIn(std::span<const std::byte> packet) {
  const std::optional<PathHeader> head = MessageIn<PathHeader>(packet);
  return head && head->mark == PathHeader{}.mark ? head : std::nullopt;
}

/// Returns a packet of that size that begins with the message; the rest is zero.
template <typename Message>
std::span<const std::byte> PacketOf(const Message& message, std::size_t bytes,
                                    std::span<std::byte> room) {
  std::memset(room.data(), 0, bytes);
  std::memcpy(room.data(), &message, sizeof message);
  return room.first(bytes);
}

}  // namespace tandem
