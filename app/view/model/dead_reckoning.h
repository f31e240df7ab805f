#pragma once

#include <cstdint>

#include "engine/base/spatial.h"

namespace tandem {

/// Where a body is drawn between two frames of its peer, and after a late one: ahead of where it
/// was told to be by how it moved then, for kLongest and kFarthest at the most, and where a frame
/// says otherwise over to that within some kSettle, without a jump. When no more frames come it
/// goes back to where it was told to be. For the picture alone: in contact, prediction draws energy
/// in (docs/decisions/0028-live-and-type-1.md). Nothing else ever sees it.
class DeadReckoning {
 public:
  static constexpr double kLongest = 0.1;    // s
  static constexpr double kFarthest = 0.03;  // m, of the body's middle
  static constexpr double kSettle = 0.05;    // s
  static constexpr double kJump = 0.1;       // m: beyond, it is somewhere else at once

  struct Told {
    std::uint32_t seq = 0;  // of the frame
    Pose X_W;               // displacement from where it stands at first
    Twist V_W;              // of that
  };

  /// `middle_W`: of the body where it stands at first; `now_s`: a clock that runs on.
  Pose Show(const Told& told, const Vec3& middle_W, double now_s);

 private:
  Pose Ahead(const Vec3& middle_W, double now_s) const;

  bool begun_ = false;
  Told told_;
  double told_s_ = 0;
  double shown_s_ = 0;
  Vec3 off_ = Vec3::Zero();     // of the middle, from Ahead(); m
  Vec3 turned_ = Vec3::Zero();  // rad
};

}  // namespace tandem
