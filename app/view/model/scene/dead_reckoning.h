#pragma once

#include <cstdint>

#include "engine/base/spatial.h"

namespace tandem {

/// Places a body in the picture between two frames of its peer, and after a late frame. It
/// extrapolates the told pose by the told velocity, for kLongest and kFarthest at most. When a new
/// frame differs, the error decays with time constant kSettle, without a jump. Without new frames
/// the body returns to the told pose.
///
/// For the picture alone: in contact, prediction would add energy
/// (docs/decisions/0028-live-and-type-1.md).
class DeadReckoning {
 public:
  static constexpr double kLongest = 0.1;    // s; longest extrapolation
  static constexpr double kFarthest = 0.03;  // m; farthest extrapolation of the body's middle
  static constexpr double kSettle = 0.05;    // s; time constant of the error
  static constexpr double kJump = 0.1;       // m; larger errors are not smoothed

  struct ReceivedMotion {
    std::uint32_t seq = 0;  // number of the frame
    Pose X_W;               // displacement from the body's first place
    Twist V_W;              // its velocity
  };

  /// Returns the pose to draw. `middle_W`: the body's middle in its first place. `now_s`: a clock
  /// that does not jump.
  Pose Show(const ReceivedMotion& reported, const Vec3& middle_W, double now_s);

 private:
  Pose Extrapolate(const Vec3& middle_W, double now_s) const;

  bool begun_ = false;
  ReceivedMotion reported_;
  double told_s_ = 0;
  double shown_s_ = 0;
  Vec3 off_ = Vec3::Zero();     // m; error of the middle, relative to Extrapolate()
  Vec3 turned_ = Vec3::Zero();  // rad; error of the rotation
};

}  // namespace tandem
