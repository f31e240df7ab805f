#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "app/process/child_processes.h"
#include "app/stability/live/tap_hub.h"
#include "collab/coupling/shared_body.h"
#include "collab/session/membership.h"
#include "engine/base/result.h"
#include "engine/haptics/hand_script.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {

/// A frame as a peer's recording shows it.
struct SeenFrame {
  std::int64_t now_ns = 0;
  Pose X_WB;      // its own instance of the cube
  Vec3 hand_f_W;  // N on that
  Vec3 links_f_W;
  std::size_t coupled = 0;    // number of others to whom the loop is closed
  std::size_t instances = 0;  // number of instances of others who are here and heard
  std::array<InstanceView, kMaxLinks> instance{};

  /// Returns the instance of that peer; null: it is not here.
  const InstanceView* InstanceOf(PeerId peer) const;
};

/// A change of another that a peer was told, and when.
struct SeenChange {
  std::int64_t now_ns = 0;
  PeerId peer = 0;
  MembershipChange::Kind kind = MembershipChange::Kind::kJoined;
};

struct SeenPeer {
  PeerId id = 0;
  std::int64_t began_ns = 0;  // begin of its hand
  std::vector<SeenFrame> frames;
  std::vector<SeenChange> changes;  // all but claims

  /// Returns the last frame before that time.
  const SeenFrame& At(std::int64_t ns) const;
  /// Returns how often a change of that kind came, of that peer.
  int Count(MembershipChange::Kind kind, PeerId peer) const;
  /// Returns when it came first; 0: never.
  std::int64_t First(MembershipChange::Kind kind, PeerId peer) const;
};

/// Peers of the product that hold one cube, each a process at a port of its own of a network of
/// real packets, which can be cut between any two. They record; what they saw is read from that.
class CutPeers {
 public:
  /// Starts peers, each with a hand that goes that way.
  explicit CutPeers(const std::vector<std::vector<Waypoint>>& hands);

  /// Waits until each has said of all others that they joined. False: not within half a minute.
  bool Meet();
  /// Cuts the way from one peer to the other, or mends it. Returns the time (ns).
  std::int64_t Cut(std::size_t from, std::size_t to, bool cut = true);
  /// Returns all that a peer has said so far.
  std::string OutputOf(std::size_t i) const;
  std::string NameOf(std::size_t i) const { return "user-" + std::to_string(i); }
  /// Ends them, and returns what each saw before that. Errors: a peer that did not end well, a
  /// recording that cannot be repeated.
  Result<std::vector<SeenPeer>> End();

 private:
  std::filesystem::path FileOf(std::size_t i, const char* ending) const;
  Result<SeenPeer> Replayed(std::size_t i, std::int64_t until_ns) const;

  ScratchFolder folder_;
  std::unique_ptr<TapHub> hub_;
  std::vector<ChildProcess> peers_;
};

}  // namespace tandem::testing
