#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "collab/messages.h"
#include "collab/partner.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Finds that something fixed is between two instances of a shared body, so that their coupling
/// cannot bring them together (paper §6.1: "instances may part for good"). By what is known here
/// alone: straight lines from points of our instance to the same points of the other's meet the
/// fixture, the two are more than kApart from one another, and that has not shrunk for kLasting.
/// A force says nothing: over a long delay a trapped link pulls with less than a free one.
///
/// The points are the centre of mass and kPoints of the surface, taken a little inward, so that a
/// body which slides along a wall does not count as beyond it. Lines are marched through the
/// fixture's distance field, or its voxmap, with distances as steps, at most kReads a frame, and
/// while all instances are together, where nobody is trapped, as few as still see everyone in 50
/// ms: a look at one partner takes some frames. Used by the haptic thread alone; nothing allocates
/// after construction.
class TrapDetector {
 public:
  static constexpr double kApart = 0.008;    // m
  static constexpr double kShrinks = 0.001;  // m: less is none
  static constexpr std::int64_t kLastingNs = 600'000'000;
  static constexpr std::size_t kPoints = 32;
  static constexpr std::size_t kReads = 192;

  explicit TrapDetector(const WorldModel& model);

  /// Another body is in hand now (into the moving bodies): what was known is forgotten.
  void Begin(std::size_t body) noexcept;
  /// A frame: our instance, and those of the others.
  void Look(std::int64_t now_ns, const Pose& X_WB, const InstanceView* others,
            std::size_t count) noexcept;

  /// Whether the fixture keeps us apart from that one.
  bool trapped(PeerId peer) const noexcept;
  /// As of the last look at it: whether a line to that one meets the fixture.
  bool blocked(PeerId peer) const noexcept;

 private:
  struct Link {
    PeerId peer = 0;  // 0: a free place
    bool blocked = false;
    bool trapped = false;
    double least = 0;           // m, since `since_ns`
    std::int64_t since_ns = 0;  // blocked and no nearer; 0: not so
  };
  /// A look at one partner that is under way.
  struct Sweep {
    std::size_t link = 0;
    PeerId peer = 0;  // 0: none is
    Pose ours, theirs;
    Mat3 R_ours = Mat3::Identity();
    Mat3 R_theirs = Mat3::Identity();
    std::size_t point = 0;
    double way = 0;    // m done of the point's line
    bool met = false;  // the fixture, on it
    std::size_t crossings = 0;
    bool centre_crosses = false;
  };

  const Link* Find(PeerId peer) const noexcept;
  void Match(const InstanceView* others, std::size_t count) noexcept;
  void BeginSweep(const Pose& X_WB, const InstanceView* others, std::size_t count) noexcept;
  /// Goes on with the point's line; gives whether it is done.
  bool March(std::size_t most, std::size_t& reads) noexcept;
  /// Whether the lines done so far say what all of them would.
  bool Decided() const noexcept;
  void Judge(Link& link, std::int64_t now_ns, double distance) noexcept;
  /// How far a line may go on from a place before it can meet the fixture, m; 0 where it has.
  /// `stretch`: the line's length by its longest share along an axis.
  double FreeAlong(const Vec3& p_W, double stretch) const noexcept;

  const WorldModel* model_;
  std::vector<std::vector<Vec3>> points_B_;  // per moving body; the first is its centre of mass
  std::size_t body_ = 0;
  std::array<Link, kMaxLinks> links_{};
  Sweep sweep_;
};

}  // namespace tandem
