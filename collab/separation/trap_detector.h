#pragma once

#include <cstdint>
#include <vector>

#include "collab/coupling/link_views.h"
#include "collab/session/messages.h"
#include "collab/session/peer_map.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Detects that something fixed separates two instances of a shared body, so that their coupling
/// cannot bring them together (paper §6.1: "instances may part for good"). Three conditions must
/// hold, all known here. Straight lines from points of our instance to the same points of the other
/// meet the fixture. The two are more than kApart from one another. Their distance has not shrunk
/// for kLastingNs. Forces tell nothing: over a long delay a trapped link pulls less than a free
/// one.
///
/// The points are the centre of mass and kPoints surface points. They are shifted a little inward,
/// so that a body sliding along a wall does not count as beyond it. Lines are marched through the
/// fixture's distance field, or its voxmap, with distances as steps, in at most kReads reads a
/// frame. While all instances are together, where no peer is trapped, it reads just enough to see
/// each peer in 50 ms; a look at one peer then takes some frames. Used by the haptic thread
/// alone; nothing allocates after construction.
class TrapDetector {
 public:
  static constexpr double kApart = 0.008;    // m
  static constexpr double kShrinks = 0.001;  // m; a smaller fall of the distance counts as none
  static constexpr std::int64_t kLastingNs = 600'000'000;
  static constexpr std::size_t kPoints = 32;
  static constexpr std::size_t kReads = 192;

  explicit TrapDetector(const WorldModel& model);

  /// Forgets all and begins with the body in hand (index into the moving bodies).
  void Begin(std::size_t body) noexcept;
  /// Examines our instance and those of the other users, for one frame.
  void Update(std::int64_t now_ns, const Pose& X_WB, const InstanceView* others,
              std::size_t count) noexcept;

  /// Returns whether the fixture keeps us apart from that peer's instance.
  bool trapped(PeerId peer) const noexcept;
  /// Returns whether a line to that peer's instance met the fixture at the last look.
  bool blocked(PeerId peer) const noexcept;

 private:
  struct Link {
    PeerId peer = 0;
    bool blocked = false;
    bool trapped = false;
    double least = 0;           // m; least distance since `since_ns`
    std::int64_t since_ns = 0;  // since when blocked and no nearer; 0: it is not
  };
  /// A look at one peer in progress.
  struct Sweep {
    std::size_t slot = 0;  // its slot in links_
    PeerId peer = 0;       // 0: none
    Pose ours, theirs;
    Mat3 R_ours = Mat3::Identity();
    Mat3 R_theirs = Mat3::Identity();
    std::size_t point = 0;
    double way = 0;    // m; part of the point's line that is done
    bool met = false;  // the line met the fixture
    std::size_t crossings = 0;
    bool centre_crosses = false;
  };

  void Match(const InstanceView* others, std::size_t count) noexcept;
  void BeginSweep(const Pose& X_WB, const InstanceView* others, std::size_t count) noexcept;
  /// Goes on with the point's line; returns whether it is done.
  bool March(std::size_t most, std::size_t& reads) noexcept;
  /// Returns whether the lines done so far decide the result for all.
  bool Decided() const noexcept;
  void Judge(Link& link, std::int64_t now_ns, double distance) noexcept;
  /// Returns how far a line may go on from a point before it can meet the fixture, m; 0 where it
  /// has met it. `stretch`: the line's length over its longest extent along an axis.
  double FreeAlong(const Vec3& p_W, double stretch) const noexcept;

  const WorldModel* model_;
  std::vector<std::vector<Vec3>> points_B_;  // per moving body; the first is its centre of mass
  std::size_t body_ = 0;
  PeerMap<Link, kMaxLinks> links_;
  Sweep sweep_;
};

}  // namespace tandem
