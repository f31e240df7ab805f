#pragma once

#include <limits>
#include <span>

#include "engine/base/linearized_force.h"
#include "engine/contact/pair/clearance.h"
#include "engine/contact/pair/contact_model.h"
#include "engine/contact/schedule/max_travel.h"
#include "engine/contact/schedule/schedule.h"

namespace tandem {

/// The pose and the motion of a body of a pair.
struct BodyMotion {
  Pose X_WB;
  Twist V_WB;
  /// No hand turns it: its balls and cylinders roll (refined model).
  bool rolls = false;
};

/// The result of a frame's test of a pair.
struct PairReport {
  int contact_points = 0;      // points whose mark is <= 2 + layer, by the class rule
  int exact_queries = 0;       // exact queries at single points (refined model)
  double query_cost = 0;       // cost of these queries and of adding up, in exact queries
  int pushing_points = 0;      // contact points that are below their tangent plane
  bool over_capacity = false;  // more contacts than can be held; the rest do not push
  TestCounts tests;
  /// Voxels are not in memory: nothing was tested, and the bodies must stand still.
  bool waits = false;
};

/// The contacts of a single pose, every point read (for `tandem contact`).
struct PoseReading {
  int contact_points = 0;
  /// Points whose mark in the surface field is <= 2 + layer, whatever the class.
  int touching_points = 0;
  int nearest_voxels =
      std::numeric_limits<int>::max();  // least distance read; max when all points are beyond
  LinearizedForce on_shell;
};

/// Two bodies that may touch, and the load that contact puts on both. The first is called the
/// shell, the second the map. All contact arithmetic is in the frame V of the map; the sums go back
/// to W. The loads are equal and opposite: both bodies get the same forces at the same places.
class BodyPair {
 public:
  virtual ~BodyPair() = default;

  /// Tests what has come due since the last call and adds the contact loads on both bodies. Does
  /// not allocate.
  virtual PairReport Collide(const BodyMotion& shell_body, const BodyMotion& map_body,
                             LinearizedForce& on_shell, LinearizedForce& on_map) noexcept = 0;
  /// Announces the voxels that will be read where the bodies stand, before the first Collide().
  virtual void Announce(const BodyMotion& /*shell_body*/, const BodyMotion& /*map_body*/) noexcept {
  }
  /// Tells the pair that it is not tested in this frame.
  virtual void Rest() noexcept {}
  /// Returns how the last Collide()'s load on the shell changes as the map moves. The transpose
  /// holds for the load on the map as the shell moves. Kept for pairs whose bodies both move.
  const CrossJacobian& cross() const noexcept { return cross_; }
  /// Returns what the next frames' tests and exact queries will cost, as of the last Collide()
  /// (paper §5, Eqn. 2).
  virtual TestDemand test_demand() const noexcept = 0;
  /// Sets how far the two bodies may come towards one another until the next Collide(), m.
  virtual void LimitTravel(double /*metres*/) noexcept {}
  /// Sets the clearance from the next Collide() on.
  virtual void SetClearance(const Clearance& clearance) noexcept = 0;
  const Clearance& clearance() const noexcept { return clearance_; }
  /// Returns the bounds of the clearance.
  virtual ClearanceBounds clearance_bounds() const noexcept = 0;
  virtual double voxel_size() const noexcept = 0;
  /// Returns the pose of V in the map's body.
  virtual Pose X_BV() const noexcept = 0;

  /// Reads every point, whatever the schedule.
  virtual PoseReading Read(const BodyMotion& shell_body, const BodyMotion& map_body) noexcept = 0;
  /// Returns the contacts of the last Collide() or Read().
  virtual std::span<const Contact> contacts() const noexcept = 0;

 protected:
  BodyPair() = default;
  BodyPair(const BodyPair&) = default;
  BodyPair& operator=(const BodyPair&) = default;

  CrossJacobian cross_;
  Clearance clearance_;
};

}  // namespace tandem
