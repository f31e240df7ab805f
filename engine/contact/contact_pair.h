#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "engine/base/load.h"
#include "engine/contact/tangent_plane.h"
#include "engine/voxel/pointshell.h"
#include "engine/voxel/voxmap.h"

namespace tandem {

/// Where a body of a pair is and how it moves.
struct BodyMotion {
  Pose X_WB;
  Twist V_WB;
};

/// What a frame's test of a pair found.
struct PairReport {
  int contact_points = 0;  // marks <= 2 + layer, by the class rule
  int loaded_points = 0;   // of these, below their tangent plane
};

/// What a single pose says, every point read (for `tandem contact`).
struct PoseReading {
  int contact_points = 0;
  int touching_points = 0;  // marks <= 2 + layer in the surface field, whatever the class
  int nearest_voxels =
      std::numeric_limits<int>::max();  // least distance read; max when all are beyond
  Load on_shell;
};

/// A pointshell body against a voxmap body (paper §2.1). All contact arithmetic lives in the
/// voxmap's frame V; the sums go back to W. Equal and opposite: both bodies get the same force at
/// the same places.
///
/// Every point is tested in every frame, and every point reads the surface field; the class rule
/// and the schedule of paper §4 and §5 come with labels.
class ContactPair {
 public:
  /// `X_BV` places V in the voxmap's body. `shell` and `voxmap` must outlive the pair.
  ContactPair(const Pointshell& shell, const Voxmap& voxmap, const Pose& X_BV, int force_layer,
              const ContactGains& gains);

  /// Tests all points and adds what contact puts on both bodies. Does not allocate.
  PairReport Collide(const BodyMotion& shell_body, const BodyMotion& map_body, Load& on_shell,
                     Load& on_map) noexcept;

  PoseReading Read(const BodyMotion& shell_body, const BodyMotion& map_body) noexcept;

  const Voxmap& voxmap() const noexcept { return *voxmap_; }

 private:
  /// Whether any point may be within the map's box: the shell's ball against the box.
  bool MayMeet(const Pose& X_VS) const noexcept;
  /// Points whose voxel is marked at most `threshold`, with their marks, into found_.
  void FindPoints(const Pose& X_VS, int threshold) noexcept;
  void AddForces(const Pose& X_VS, const BodyMotion& shell_body, const BodyMotion& map_body,
                 const Pose& X_WV, PairReport& report, Load& on_shell, Load& on_map) const noexcept;

  struct Found {
    std::uint32_t point;
    GridIndex voxel;
    int value;
  };

  const Pointshell* shell_;
  const Voxmap* voxmap_;
  Pose X_BV_;
  int force_layer_;
  ContactGains gains_;
  std::vector<Found> found_;  // as large as the shell
  std::size_t found_count_ = 0;
};

}  // namespace tandem
