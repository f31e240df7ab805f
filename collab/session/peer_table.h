#pragma once

#include <array>
#include <cstdint>

#include "collab/session/drop_counts.h"
#include "collab/session/frame_limits.h"
#include "collab/session/messages.h"

namespace tandem {

/// This peer's view of another active peer and of the coupling to it: shown, printed and reported,
/// applied nowhere.
struct PeerTableRow {
  PeerId peer = 0;
  // age of the loop to it and back: grows without echoes; 0: none came yet, or a hand is empty
  double loop_age_s = 0;
  double delay_s = 0;         // half of it
  bool coupled = false;       // both hold the same body, and the loop is closed
  double stiffness = 0;       // N/m in use by that coupling
  double link_force = 0;      // N; on our instance
  double its_link_force = 0;  // N; on its instance, as it says
  double disagreement = 0;    // |ours + its| / the larger, of the two wrenches; 0 at rest
  double mirror_lag_m = 0;    // greatest lag of the mirrors of bodies that it moves
  double mirror_age_s = -1;   // since its newest state came; -1: none has
  bool trapped = false;       // something fixed separates our instances
  FrameLimits limits;         // its frames of the last second, as it said with its newest state
  DropCounts drops{};         // samples dropped from it, by reason
};

/// The rows of all other active peers, ten times a second.
struct PeerTable {
  static constexpr std::int64_t kPeriod = 100;  // frames

  std::int64_t time_ns = 0;
  FrameLimits own_limits;  // our frames of the last second
  int own_layer = -1;      // force layer of the body in hand; -1: the scene's
  double own_displacement_m = 0;
  bool own_stopped = false;  // our hand is in an emergency stop
  std::uint32_t count = 0;
  std::array<PeerTableRow, kMaxPeers> rows{};
};

}  // namespace tandem
