#include "collab/simulated/hands/checkers/goal_hand_checker.h"

#include <algorithm>
#include <cmath>

namespace tandem {

namespace {

constexpr std::int64_t kChangeNs = 100'000'000;
constexpr double kCouplingStiffness = 800;  // N/m, for every hand's coupling
constexpr double kCouplingDamping = 8;      // N s/m
constexpr double kMostLead = 0.5;           // rad
constexpr double kPushed = 0.5;             // m/s, from others' bodies: half a voxel a frame
constexpr double kFrameS = 1e-3;

}  // namespace

double GoalHandChecker::Limit::At(std::int64_t now_ns) const {
  return now_ns - changed_ns < kChangeNs ? std::max(now, before) : now;
}

void GoalHandChecker::Set(const std::string& name, double value, std::int64_t now_ns) {
  if (name != "hand_force_N" && name != "hand_speed_m_s") return;
  Limit& limit = name == "hand_force_N" ? force_ : speed_;
  limit = {.now = value, .before = limit.At(now_ns), .changed_ns = now_ns};
}

void GoalHandChecker::Check(const HandObservation& sight) {
  const bool same = sight.attached && sight.held == held_;
  frames_ = same && !sight.led ? frames_ + 1 : 0;
  held_ = sight.attached ? sight.held : -1;
  if (frames_ < 2) return;
  const double force = force_.At(sight.now_ns);
  const double speed = speed_.At(sight.now_ns);
  const Twist& V = sight.body.V_WB;
  const double at_grasp = (V.v + V.w.cross(sight.X_WG.p - sight.body.X_WB.p)).norm();
  // within a frame the handle moves first, then the part
  const double lead = (sight.handle.p - sight.X_WG.p).norm();
  if (lead > force / kCouplingStiffness + 1.5 * kFrameS * at_grasp + 1e-6) {
    violations_->Add("a goal leads its part by more than the force limit", id_,
                     Text("%.2f mm at %.1f N", 1e3 * lead, force));
  }
  const double turn = sight.handle.q.angularDistance(sight.X_WG.q);
  if (turn > kMostLead + 1.5 * kFrameS * V.w.norm() + 1e-6) {
    violations_->Add("a goal is turned too far ahead of its part", id_, Text("%.3f rad", turn));
  }
  const double pull = sight.pull_B_W.f.norm();
  const double most =
      2 * force + kCouplingDamping * (speed + at_grasp) + kCouplingStiffness * kFrameS * at_grasp;
  if (pull > 1.02 * most + 0.1) {
    violations_->Add("a hand pulls with more than its limit", id_,
                     Text("%.2f N in place of %.2f", pull, most));
  }
  const double fastest = speed + force / std::sqrt(kCouplingStiffness * sight.mass) + kPushed;
  if (sight.alone && V.v.norm() > fastest) {
    violations_->Add("a part is faster than its goal makes it", id_,
                     Text("%.2f m/s in place of %.2f", V.v.norm(), fastest));
  }
}

}  // namespace tandem
