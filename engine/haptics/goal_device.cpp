#include "engine/haptics/goal_device.h"

#include <algorithm>
#include <cmath>

#include "engine/world/world.h"

namespace tandem {

namespace {

/// Returns `v`, shortened to `most`.
Vec3 Shortened(const Vec3& v, double most) noexcept {
  const double length = v.norm();
  return length > most ? Vec3(v * (most / length)) : v;
}

}  // namespace

void GoalDevice::See(const PartInHand& part) noexcept {
  const GoalOrder& order = orders_->newest.Read();
  part_ = part;
  TakeOrder(order);
  const int attached = part_.attached ? part_.wanted : -1;
  if (attached >= 0 && attached != attached_) {
    // keeps_way of an order holds for its first part only: a part that another program puts into
    // the hand later counts as newly taken
    const bool to_go_back = order.keeps_way && order.grasp_seq != attached_seq_ &&
                            order.body == attached && way_.body() == attached;
    if (!to_go_back) way_.Begin(attached, part_.radius, part_.state.X_WB);
    attached_seq_ = order.grasp_seq;
  }
  attached_ = attached;
  if (part_.attached) {
    way_.Note(part_.state.X_WB);
    way_.Advance(part_.state.X_WB);
  } else if (part_.wanted >= 0 && part_.wanted == order.body) {
    Grasp(order);
  } else if (part_.wanted >= 0) {
    // taken by another program than a host: as it stands
    handle_ = {part_.state.X_WB, {}};
    requested_ = handle_.X_WA;
  }
}

void GoalDevice::TakeOrder(const GoalOrder& order) noexcept {
  input_frames_ = std::min(input_frames_ + 1, kRateFrames);
  if (order.input_seq != input_seq_) {
    input_seq_ = order.input_seq;
    input_frames_ = 0;
    way_.Stop();
    said_since_grasp_ = order.input == GoalOrder::Input::kPose;
    if (said_since_grasp_) requested_ = order.X_WG;
  }
  if (order.grasp_seq != grasp_seq_) {
    grasp_seq_ = order.grasp_seq;
    placed_ = false;
    way_.Stop();
    const bool since = order.input_seq != order.void_seq;
    said_since_grasp_ = since && order.input == GoalOrder::Input::kPose;
    if (!since) input_frames_ = kRateFrames;
  }
  if (order.way_seq == way_seq_) return;
  way_seq_ = order.way_seq;
  if (order.way == GoalOrder::Way::kDrop) way_.Drop();
  if (order.way == GoalOrder::Way::kNone) way_.Stop();
  if (order.way == GoalOrder::Way::kBack && part_.attached && way_.body() == part_.wanted) {
    way_.SetOut(part_.state.X_WB);
  }
}

void GoalDevice::Grasp(const GoalOrder& order) noexcept {
  // the part may move until it is in hand: the handle stays on it
  const Pose& X_WB = part_.state.X_WB;
  if (!placed_) p_BG_ = order.at_centre ? Vec3(Vec3::Zero()) : X_WB.Inverse() * order.p_WG;
  placed_ = true;
  handle_ = {{Quat::Identity(), X_WB * p_BG_}, {}};
  if (!said_since_grasp_) requested_ = handle_.X_WA;
}

Anchor GoalDevice::Read() noexcept {
  if (!part_.attached) {
    handle_.V_WA = {};
    limited_ = false;
    return handle_;
  }
  const GoalOrder& order = orders_->newest.Read();
  const Pose before = handle_.X_WA;
  limited_ = false;
  const Pose next = WithinLead(Next(order), order.limits);
  handle_.X_WA = {next.q.normalized(), next.p};
  handle_.V_WA = {};
  // a handle that the limit drags along pulls with its spring alone
  if (!limited_) {
    handle_.V_WA = {
        Shortened(RotationVector(next.q * before.q.conjugate()) / kFrame, order.limits.spin),
        Shortened((next.p - before.p) / kFrame, order.limits.speed)};
    Calm(order.limits);
  }
  return handle_;
}

void GoalDevice::Calm(const GoalLimits& limits) noexcept {
  // no arm holds this handle: its velocity adds what the coupling's damper lacks
  const double k = part_.gains.stiffness;
  const double damping = part_.gains.damping;
  if (!(k > 0) || !(damping > 0)) return;
  const double lack = 2.0 * kDampingRatio * std::sqrt(k * part_.mass) / damping - 1.0;
  if (lack <= 0) return;
  const Vec3 arm = part_.state.X_WB.q * part_.X_BG.p;
  const Twist& body = part_.state.V_WB;
  const double most = limits.force / damping;
  const double gyration =
      std::sqrt(std::max(part_.gains.rotation_stiffness.trace() / (3.0 * k), 1e-12));
  handle_.V_WA.v += Shortened(lack * (handle_.V_WA.v - (body.v + body.w.cross(arm))), most);
  handle_.V_WA.w += Shortened(lack * (handle_.V_WA.w - body.w), most / gyration);
}

Pose GoalDevice::Next(const GoalOrder& order) noexcept {
  const Pose& now = handle_.X_WA;
  if (way_.state() == PathBacktracker::State::kUnderWay ||
      way_.state() == PathBacktracker::State::kArrived ||
      way_.state() == PathBacktracker::State::kStuck ||
      way_.state() == PathBacktracker::State::kCut) {
    // the hand stays where the way has brought it until the user gives a new order
    requested_ = way_.goal() * part_.X_BG;
    return requested_;
  }
  if (order.input == GoalOrder::Input::kPose || input_seq_ == 0) {
    return StepTowards(requested_, order.limits);
  }
  if (input_frames_ >= kRateFrames) return now;
  const bool push = order.input == GoalOrder::Input::kPush;
  const Vec3 v = Shortened((push ? kPushYield : 1.0) * order.linear, order.limits.speed);
  const Vec3 w = Shortened((push ? kPushTurn : 1.0) * order.angular, order.limits.spin);
  requested_ = {RotationBy(kFrame * w) * now.q, now.p + kFrame * v};
  return requested_;
}

Pose GoalDevice::StepTowards(const Pose& target, const GoalLimits& limits) const noexcept {
  const Pose& now = handle_.X_WA;
  const double share = limits.smoothing > 0 ? 1.0 - std::exp(-kFrame / limits.smoothing) : 1.0;
  const Vec3 step = Shortened(share * (target.p - now.p), kFrame * limits.speed);
  const Vec3 turn =
      Shortened(share * RotationVector(target.q * now.q.conjugate()), kFrame * limits.spin);
  return {RotationBy(turn) * now.q, now.p + step};
}

Pose GoalDevice::WithinLead(const Pose& handle, const GoalLimits& limits) noexcept {
  const Pose part = part_.state.X_WB * part_.X_BG;
  const double k = part_.gains.stiffness;
  if (!(k > 0)) return handle;
  const double most = limits.force / k;
  const double k_turn = part_.gains.rotation_stiffness.trace() / 3.0;
  // moment of that force at the radius of gyration
  const double most_turn =
      k_turn > 0 ? std::min(kMostLeadAngle, most * std::sqrt(k / k_turn)) : kMostLeadAngle;
  const Vec3 lead = handle.p - part.p;
  const Vec3 turn = RotationVector(handle.q * part.q.conjugate());
  limited_ = lead.norm() > most || turn.norm() > most_turn;
  if (!limited_) return handle;
  return {RotationBy(Shortened(turn, most_turn)) * part.q, part.p + Shortened(lead, most)};
}

}  // namespace tandem
