#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "engine/haptics/device.h"
#include "engine/haptics/path_backtracker.h"
#include "engine/realtime/triple_buffer.h"

namespace tandem {

/// A user's settings for an input without force feedback, and their bounds.
struct GoalLimits {
  static constexpr double kMostForce = 30.0;  // N, as for any hand
  static constexpr double kMostSpeed = 2.0;   // m/s

  double force = 10.0;       // greatest force of the spring on the part, N
  double speed = 1.0;        // speed of the goal, m/s
  double spin = 4.0;         // rad/s
  double smoothing = 0.015;  // smoothing of goals that come fewer than a thousand times a second, s
};

/// The newest order of a user; each `seq` grows with the events that it counts.
struct GoalOrder {
  enum class Input : std::uint8_t { kPose, kRate, kPush };
  enum class Way : std::uint8_t { kNone, kBack, kDrop };

  std::uint32_t input_seq = 0;
  Input input = Input::kPose;
  Pose X_WG;                    // kPose: target of the grasp frame
  Vec3 linear = Vec3::Zero();   // kRate: m/s; kPush: N
  Vec3 angular = Vec3::Zero();  // rad/s; N m

  std::uint32_t grasp_seq = 0;  // requests to take a part
  int body = -1;
  bool at_centre = true;     // the part is grasped at its centre of mass
  Vec3 p_WG = Vec3::Zero();  // else at this place
  bool keeps_way = false;    // no new stretch of way begins: the part is taken to go back
  std::uint32_t void_seq =
      /// The newest input at the request: it and all before it are ignored.
      0;

  std::uint32_t way_seq = 0;
  Way way = Way::kNone;
  GoalLimits limits;
};

/// The part, as in the simulation at the beginning of a frame.
struct PartInHand {
  int wanted = -1;        // index into the world's moving bodies: in hand, requested, or aimed at
  bool attached = false;  // the hand has grasped it
  RigidState state;       // state of that body
  Pose X_BG;              // grasp, once attached
  CouplingGains gains;    // gains of the hand's coupling to it
  double mass = 0;        // mass of the part, kg
  double radius = 0;      // m
};

/// A user's hand whose input comes from outside the loop, without force feedback: from a mouse, a
/// SpaceMouse, or the goals of a host application (paper §6, §6.2). The handle follows the user's
/// target at a bounded speed, but never farther ahead of the part than the coupling's spring may
/// pull. So the force on the part is limited, a part that was held up is not flung when it comes
/// free, and no goal takes a part through another. A push moves the goal on at a velocity in
/// proportion to it, a rate at that velocity. Both stop where the limit holds the handle.
///
/// One other thread writes orders; all else belongs to the haptic thread.
class GoalDevice : public Device {
 public:
  static constexpr int kRateFrames = 200;        // frames that a rate or a push lasts
  static constexpr double kPushYield = 0.02;     // m/s a newton
  static constexpr double kPushTurn = 2.0;       // rad/s a newton metre
  static constexpr double kDampingRatio = 0.7;   // least damping ratio of part and coupling
  static constexpr double kMostLeadAngle = 0.5;  // rad

  struct Orders {
    TripleBuffer<GoalOrder> newest;
  };

  explicit GoalDevice(std::shared_ptr<Orders> orders) : orders_(std::move(orders)) {}

  /// Returns the part that is to be taken next, or was taken last; -1: none.
  int aimed_at() const noexcept { return orders_->newest.Read().body; }
  /// Takes the state of the part; called before each frame.
  void See(const PartInHand& part) noexcept;

  void Start() noexcept override {}
  Anchor Read() noexcept override;
  void Render(const Wrench&) noexcept override {}

  /// Return the user's target of the grasp frame, and the pose to which the coupling pulls it.
  const Pose& requested() const noexcept { return requested_; }
  const Anchor& handle() const noexcept { return handle_; }
  /// Tells whether the limit holds the handle back.
  bool limited() const noexcept { return limited_; }
  const PathBacktracker& way() const noexcept { return way_; }
  /// Return the newest orders that were seen.
  std::uint32_t grasp_seq() const noexcept { return grasp_seq_; }
  std::uint32_t way_seq() const noexcept { return way_seq_; }

 private:
  void TakeOrder(const GoalOrder& order) noexcept;
  void Grasp(const GoalOrder& order) noexcept;
  /// Damps oscillation at the handle, with at most the force limit once more.
  void Calm(const GoalLimits& limits) noexcept;
  /// Returns where the handle goes in this frame, without the limit on its lead.
  Pose Next(const GoalOrder& order) noexcept;
  Pose StepTowards(const Pose& target, const GoalLimits& limits) const noexcept;
  Pose WithinLead(const Pose& handle, const GoalLimits& limits) noexcept;

  std::shared_ptr<Orders> orders_;
  PartInHand part_;
  PathBacktracker way_;
  Pose requested_;
  Anchor handle_;
  bool limited_ = false;
  int attached_ = -1;               // body grasped in the last frame
  std::uint32_t attached_seq_ = 0;  // newest grasp_seq when that body was grasped
  bool placed_ = false;             // the grasped point is known
  Vec3 p_BG_ = Vec3::Zero();
  std::uint32_t input_seq_ = 0;
  std::uint32_t grasp_seq_ = 0;
  std::uint32_t way_seq_ = 0;
  int input_frames_ = 0;           // frames since the newest input
  bool said_since_grasp_ = false;  // a pose was given since the last request to take a part
};

}  // namespace tandem
