#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "engine/haptics/device.h"
#include "engine/haptics/way_back.h"
#include "engine/realtime/triple_buffer.h"

namespace tandem {

/// What a user's numbers for an input without force feedback are, and between which they may be.
struct GoalLimits {
  static constexpr double kMostForce = 30.0;  // N, as of any hand
  static constexpr double kMostSpeed = 2.0;   // m/s

  double force = 10.0;       // N, of the spring on the part at the most
  double speed = 1.0;        // m/s, of the goal
  double spin = 4.0;         // rad/s
  double smoothing = 0.015;  // s, of goals that come fewer than a thousand times a second
};

/// The newest that is known of what a user means; each `seq` grows with what it counts.
struct GoalOrder {
  enum class Input : std::uint8_t { kPose, kRate, kPush };
  enum class Way : std::uint8_t { kNone, kBack, kDrop };

  std::uint32_t input_seq = 0;
  Input input = Input::kPose;
  Pose X_WG;                    // kPose: where the grasp frame is to be
  Vec3 linear = Vec3::Zero();   // kRate: m/s; kPush: N
  Vec3 angular = Vec3::Zero();  // rad/s; N m

  std::uint32_t grasp_seq = 0;  // a part is to be taken
  int body = -1;
  bool at_centre = true;     // grasped at its centre of mass
  Vec3 p_WG = Vec3::Zero();  // else there
  bool keeps_way = false;    // no new stretch of way begins: it is taken to go back
  std::uint32_t void_seq =
      0;  // the newest input when it was asked for: not gone to, nor those before

  std::uint32_t way_seq = 0;
  Way way = Way::kNone;
  GoalLimits limits;
};

/// The part, as the simulation has it at the beginning of a frame.
struct PartInHand {
  int wanted = -1;        // into the world's moving bodies: in hand, asked for, or aimed at
  bool attached = false;  // the hand has grasped it
  RigidState state;       // of that one
  Pose X_BG;              // grasp, once attached
  CouplingGains gains;    // of the hand's coupling to it
  double mass = 0;        // kg, of the part
  double radius = 0;      // m
};

/// A user's hand whose input comes from outside the loop, without force feedback: from a mouse, a
/// SpaceMouse, or the goals of a host application (paper §6, §6.2). The handle goes where the user
/// means at a bounded speed, but never farther ahead of the part than the coupling's spring may
/// pull: so the force on the part is limited, a part that is held up is not flung when it comes
/// free, and no goal takes a part through another. A push moves the goal on at a velocity in
/// proportion to it, a rate at that velocity; both stop where the limit holds the handle.
///
/// Orders are written by one other thread; all else belongs to the haptic thread.
class GoalDevice : public Device {
 public:
  static constexpr int kRateFrames = 200;        // that a rate or a push lasts
  static constexpr double kPushYield = 0.02;     // m/s a newton
  static constexpr double kPushTurn = 2.0;       // rad/s a newton metre
  static constexpr double kDampingRatio = 0.7;   // of part and coupling, at the least
  static constexpr double kMostLeadAngle = 0.5;  // rad

  struct Orders {
    TripleBuffer<GoalOrder> newest;
  };

  explicit GoalDevice(std::shared_ptr<Orders> orders) : orders_(std::move(orders)) {}

  /// The part that is to be taken next, or was taken last; -1: none.
  int aimed_at() const noexcept { return orders_->newest.Read().body; }
  /// Before each frame: where the part is.
  void See(const PartInHand& part) noexcept;

  void Start() noexcept override {}
  Anchor Read() noexcept override;
  void Render(const Wrench&) noexcept override {}

  /// Where the user means the grasp frame to be, and where the coupling pulls it.
  const Pose& asked() const noexcept { return asked_; }
  const Anchor& handle() const noexcept { return handle_; }
  /// Whether the limit holds the handle back.
  bool limited() const noexcept { return limited_; }
  const WayBack& way() const noexcept { return way_; }
  /// The newest orders that were seen.
  std::uint32_t grasp_seq() const noexcept { return grasp_seq_; }
  std::uint32_t way_seq() const noexcept { return way_seq_; }

 private:
  void TakeOrder(const GoalOrder& order) noexcept;
  void Grasp(const GoalOrder& order) noexcept;
  /// Damps what swings at the handle, with no more than the force limit once more.
  void Calm(const GoalLimits& limits) noexcept;
  /// Where the handle goes in this frame, but for the limit on its lead.
  Pose Next(const GoalOrder& order) noexcept;
  Pose Towards(const Pose& target, const GoalLimits& limits) const noexcept;
  Pose WithinLead(const Pose& handle, const GoalLimits& limits) noexcept;

  std::shared_ptr<Orders> orders_;
  PartInHand part_;
  WayBack way_;
  Pose asked_;
  Anchor handle_;
  bool limited_ = false;
  int attached_ = -1;               // grasped in the last frame
  std::uint32_t attached_seq_ = 0;  // the order that was the newest when it was
  bool placed_ = false;             // the grasped point is known
  Vec3 p_BG_ = Vec3::Zero();
  std::uint32_t input_seq_ = 0;
  std::uint32_t grasp_seq_ = 0;
  std::uint32_t way_seq_ = 0;
  int input_frames_ = 0;           // since the newest input
  bool said_since_grasp_ = false;  // a pose, since a part is to be taken
};

}  // namespace tandem
