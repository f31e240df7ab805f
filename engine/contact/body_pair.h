#pragma once

#include <limits>
#include <span>

#include "engine/base/load.h"
#include "engine/contact/clearance.h"
#include "engine/contact/contact_model.h"
#include "engine/contact/max_travel.h"
#include "engine/contact/schedule.h"

namespace tandem {

/// Where a body of a pair is and how it moves.
struct BodyMotion {
  Pose X_WB;
  Twist V_WB;
};

/// What a frame's test of a pair found.
struct PairReport {
  int contact_points = 0;      // marks <= 2 + layer, by the class rule
  int looks = 0;               // exact looks at single points (refined model)
  double look_work = 0;        // what these and adding up came to, in exact looks
  int loaded_points = 0;       // of the contact points, below their tangent plane
  bool over_capacity = false;  // more contacts than can be held; the rest did not push
  TestCounts tests;
  bool waits = false;  // voxels were not in memory: nothing was tested, and the bodies are to stand
};

/// What a single pose says, every point read (for `tandem contact`).
struct PoseReading {
  int contact_points = 0;
  int touching_points = 0;  // marks <= 2 + layer in the surface field, whatever the class
  int nearest_voxels =
      std::numeric_limits<int>::max();  // least distance read; max when all are beyond
  Load on_shell;
};

/// Two bodies that may touch, and what contact puts on both. All contact arithmetic lives in the
/// frame V of the second one's map; the sums go back to W. Equal and opposite: both bodies get the
/// same force at the same places. The first is called the shell, the second the map.
class BodyPair {
 public:
  virtual ~BodyPair() = default;

  /// Tests what has come due since the last call and adds what contact puts on both bodies. Does
  /// not allocate.
  virtual PairReport Collide(const BodyMotion& shell_body, const BodyMotion& map_body,
                             Load& on_shell, Load& on_map) noexcept = 0;
  /// Says which voxels will be read where the bodies stand, before the first Collide().
  virtual void Announce(const BodyMotion& /*shell_body*/, const BodyMotion& /*map_body*/) noexcept {
  }
  /// The pair is not tested in this frame.
  virtual void Rest() noexcept {}
  /// How the last Collide()'s load on the shell changes as the map moves; the transpose the other
  /// way round. Kept for pairs that both move.
  const CrossLoad& cross() const noexcept { return cross_; }
  /// What the next frames' tests and looks will cost, as of the last Collide() (paper §5, Eqn. 2).
  virtual TestLoad load() const noexcept = 0;
  /// How far the two bodies may come towards one another before the next Collide(), m.
  virtual void LimitTravel(double /*metres*/) noexcept {}
  /// From the next Collide() on.
  virtual void SetClearance(const Clearance& clearance) noexcept = 0;
  const Clearance& clearance() const noexcept { return clearance_; }
  /// What the clearance may be.
  virtual ClearanceBounds clearance_bounds() const noexcept = 0;
  virtual double voxel_size() const noexcept = 0;
  /// Where V stands in the map's body.
  virtual Pose X_BV() const noexcept = 0;

  /// Reads every point, whatever the schedule.
  virtual PoseReading Read(const BodyMotion& shell_body, const BodyMotion& map_body) noexcept = 0;
  /// Where the bodies pushed each other in the last Collide() or Read().
  virtual std::span<const Contact> contacts() const noexcept = 0;

 protected:
  BodyPair() = default;
  BodyPair(const BodyPair&) = default;
  BodyPair& operator=(const BodyPair&) = default;

  CrossLoad cross_;
  Clearance clearance_;
};

}  // namespace tandem
