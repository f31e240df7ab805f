#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include "collab/messages.h"

namespace tandem {

/// Why a sample was dropped: no sound peer sends such. Late ones are among the replayed.
enum class Drop : std::uint8_t {
  kNotFinite,    // NaN or infinite
  kHuge,         // beyond the wire's bounds
  kNotUnit,      // a quaternion off unit length by more than a thousandth
  kBadCount,     // more entries than there is room for, or of nobody
  kWrongOwner,   // in another's name, or of a body that its sender does not answer for
  kNoOwner,      // from a writer that is nobody's
  kReplayed,     // not newer than what the sender said last
  kWrongEpoch,   // of another time than its sender's claim
  kBadEcho,      // echoes a stamp that we never sent
  kRingFull,     // the haptic thread stood still, or its sender has its share of the room
  kFlood,        // its writer sends more than any sound one: not heard for a while
  kManyKeys,     // of more instances than its writer may have
  kManyWriters,  // of more writers than its program, or all together, may have
  kImpostor,     // presence, manifest or event in another's name, or of another's seat
  kTwin,         // the same keys are used twice: of the one that came later
  kRevoked,      // of keys that are not valid any more
  kStranger,     // an event of somebody who is not here
  kNotOwner,     // grants, hands on or refuses what it does not answer for
  kSeized,       // claims what another has and has not given away
  kEpochLeap,    // claims further ahead than anybody can have come by grabbing
  kAbsurdScene,  // offers what no scene can be
  kCount
};

inline constexpr std::size_t kDropReasons = static_cast<std::size_t>(Drop::kCount);
using DropCounts = std::array<std::uint64_t, kDropReasons>;

const char* NameOf(Drop reason) noexcept;  // "not_finite" …
/// What its sender does, for a person: "claims what others have"; null: nothing that is told.
const char* InWords(Drop reason) noexcept;
/// From how many on it is told: a few of some come of messages that cross.
std::uint64_t TellFrom(Drop reason) noexcept;
std::uint64_t SumOf(const DropCounts& counts) noexcept;

/// How many samples were dropped, by their sender and the reason. Counted by the receive and the
/// haptic thread, read by any; nothing allocates in Count().
class DropTable {
 public:
  /// `peer`: whose they are as far as the way they came tells; 0: nobody's.
  void Count(PeerId peer, Drop reason) noexcept;

  DropCounts Of(PeerId peer) const noexcept;
  DropCounts Total() const noexcept;
  std::vector<std::pair<PeerId, DropCounts>> Rows() const;  // senders with drops; 0 is nobody

 private:
  struct Row {
    std::atomic<PeerId> peer = 0;
    std::array<std::atomic<std::uint64_t>, kDropReasons> counts{};
  };

  Row& RowOf(PeerId peer) noexcept;
  static DropCounts Read(const Row& row) noexcept;

  // those that come and go beyond the last row are counted with nobody's
  std::array<Row, 4 * kMaxPeers> rows_;
  Row nobody_;
};

}  // namespace tandem
