#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <utility>
#include <vector>

#include "collab/session/messages.h"

namespace tandem {

/// Reasons to drop a sample; no sound peer causes them. Late samples count as replayed.
enum class Drop : std::uint8_t {
  kNotFinite,    // NaN or infinite
  kHuge,         // beyond the bounds of the wire format
  kNotUnit,      // a quaternion off unit length by more than a thousandth
  kBadCount,     // more entries than there is room for, or an entry for no peer
  kWrongOwner,   // in another's name, or about a body that its sender does not answer for
  kNoOwner,      // from a writer that belongs to no participant
  kReplayed,     // not newer than the sender's last
  kWrongEpoch,   // under another epoch than its sender's claim
  kBadEcho,      // echoes a stamp that we never sent
  kRingFull,     // the haptic thread stalled, or the sender used up its share of the queue
  kFlood,        // the writer sends more than any sound writer: muted for a while
  kManyKeys,     // more instances than the writer may have
  kManyWriters,  // more writers than the program, or all programs together, may have
  kImpostor,     // presence, manifest or event in another's name, or for another's seat
  kTwin,         // keys used twice: from the program that came later
  kRevoked,      // from keys that have been revoked
  kStranger,     // an event from a peer that is not in the session
  kNotOwner,     // a grant, hand-over or refusal by a peer that does not answer for the body
  kSeized,       // claims a body that another peer has and has not given away
  kEpochLeap,    // claims an epoch further ahead than grabbing can reach
  kAbsurdScene,  // offers an impossible scene
  kCount
};

inline constexpr std::size_t kDropReasons = static_cast<std::size_t>(Drop::kCount);
using DropCounts = std::array<std::uint64_t, kDropReasons>;

const char* NameOf(Drop reason) noexcept;  // "not_finite" …
/// Says for a person what the sender does: "claims bodies that others have and have not given
/// away"; null: the person is not told of this reason.
const char* ReasonText(Drop reason) noexcept;
/// Returns the count from which on the user is told. A few drops of some reasons arise from
/// messages that cross.
std::uint64_t TellFrom(Drop reason) noexcept;
std::uint64_t SumOf(const DropCounts& counts) noexcept;

/// Counts dropped samples by sender and reason. The receive and the haptic thread count, any thread
/// reads; Count() does not allocate.
class DropTable {
 public:
  /// `peer`: the owner of the sample as far as its path tells; 0: unknown.
  void Count(PeerId peer, Drop reason) noexcept;

  DropCounts CountsOf(PeerId peer) const noexcept;
  DropCounts Total() const noexcept;
  std::vector<std::pair<PeerId, DropCounts>> Rows() const;  // senders with drops; 0: unknown sender

 private:
  struct Row {
    std::atomic<PeerId> peer = 0;
    std::array<std::atomic<std::uint64_t>, kDropReasons> counts{};
  };

  Row& RowOf(PeerId peer) noexcept;
  static DropCounts Read(const Row& row) noexcept;

  // senders beyond the last row are counted with the unknown sender
  std::array<Row, 4 * kMaxPeers> rows_;
  Row nobody_;
};

}  // namespace tandem
