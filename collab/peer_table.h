#pragma once

#include <array>
#include <cstdint>

#include "collab/drop_counts.h"
#include "collab/frame_limits.h"
#include "collab/messages.h"

namespace tandem {

/// What we know of another active peer and of our coupling to it: shown, printed and reported,
/// applied nowhere.
struct PeerTableRow {
  PeerId peer = 0;
  double loop_age_s = 0;      // to it and back, now: grows while nothing of ours comes back
                              // 0: nothing has yet, or one of us holds nothing
  double delay_s = 0;         // half of it
  bool coupled = false;       // we hold the same body, and its loop is closed
  double stiffness = 0;       // N/m in use, of that coupling
  double link_force = 0;      // N, on our instance
  double its_link_force = 0;  // N, on its instance, as it says
  double disagreement = 0;    // of the two wrenches: |ours + its| / the larger; 0 at rest
  double mirror_lag_m = 0;    // of the bodies that it moves: the farthest from where it said
  double mirror_age_s = -1;   // since the newest state of it came; -1: none has
  bool trapped = false;       // something fixed is between our instances
  FrameLimits limits;         // of its frames in a second, as it said with its newest state
  DropCounts drops{};         // of what came from it, by reason
};

/// All of them, ten times a second.
struct PeerTable {
  static constexpr std::int64_t kPeriod = 100;  // frames

  std::int64_t time_ns = 0;
  FrameLimits own_limits;  // of our frames in the last second
  int own_layer = -1;      // force layer of what our hand holds; -1: the scene's
  double own_displacement_m = 0;
  std::uint32_t count = 0;
  std::array<PeerTableRow, kMaxPeers> rows{};
};

}  // namespace tandem
