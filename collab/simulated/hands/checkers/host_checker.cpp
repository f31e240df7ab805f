#include "collab/simulated/hands/checkers/host_checker.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr std::int64_t kFewFrames = 5 * kMs;
// the controller looks at its simulation every 10 ms where a host wants few snapshots, else sooner
constexpr std::int64_t kLooksNs = 60 * kMs;
constexpr std::int64_t kQuietNs = 150 * kMs;
constexpr std::int64_t kLostNs = 500 * kMs;
constexpr std::int64_t kLostAgoNs = 30 * kMs;  // time until the hand has let go
constexpr std::int64_t kRateNs = 200 * kMs;    // time for which a rate and a push last
constexpr double kWayBackSpeed = 0.05;  // m/s, lower bound; a way back goes at 0.25, and waits for
                                        // 2 s where it is held up
constexpr double kFarthest = 1e3;       // m

bool TakesHand(const ControlRequest& request) {
  return std::holds_alternative<GrabRequest>(request) ||
         std::holds_alternative<AskForRequest>(request) ||
         std::holds_alternative<RetraceRequest>(request);
}

/// Returns how long a request's answer may take, s, without the length of a way.
double MostSeconds(const ControlRequest& request) {
  if (std::holds_alternative<SaveRequest>(request) ||
      std::holds_alternative<VoxelizeRequest>(request) ||
      std::holds_alternative<LoadSceneRequest>(request)) {
    return 3;  // the simulated jobs
  }
  if (std::holds_alternative<GiveRequest>(request)) return 7.2;
  if (std::holds_alternative<ReleaseRequest>(request)) return 2.2;
  return TakesHand(request) ? 11.2 : 0.1;  // to let go, to aim, to take
}

bool SamePlace(const Pose& a, const Pose& b) {
  return a.p == b.p && a.q.coeffs() == b.q.coeffs();
}

bool IsSound(const Vec3& v) {
  return v.allFinite() && v.cwiseAbs().maxCoeff() < kFarthest;
}

bool IsPlace(const HostGoal& goal) {
  return IsSound(goal.X_WG.p) && IsSound(goal.linear) && IsSound(goal.angular) &&
         std::abs(goal.X_WG.q.norm() - 1.0) < 1e-3;
}

}  // namespace

void HostChecker::OnGoal(HostId host, const HostGoal& goal, std::int64_t now_ns) {
  if (goal.kind == HostGoal::Kind::kGoodbye) return Lose(host, now_ns);
  Host& known = hosts_[host];
  // after a silence the hand may go to the host's goal again
  if (now_ns - known.received_ns > kQuietNs - kLooksNs && known.stated)
    known.moved_ns = now_ns + kLooksNs;
  known.received_ns = now_ns;
  const bool newer = goal.seq > std::exchange(known.seq, std::max(known.seq, goal.seq));
  if (goal.kind == HostGoal::Kind::kBeat || !newer) return;
  known.stated.reset();
  if (!IsPlace(goal)) return;
  const bool lasts = goal.kind != HostGoal::Kind::kPose;
  known.stated = lasts ? std::nullopt : std::optional(Pose{goal.X_WG.q.normalized(), goal.X_WG.p});
  known.said_ns = now_ns;
  known.moved_ns = std::max(known.moved_ns, now_ns + kFewFrames + (lasts ? kRateNs : 0));
}

void HostChecker::OnRequest(HostId host, std::uint64_t number, const ControlRequest& request,
                            bool refused, std::int64_t now_ns) {
  hosts_[host].received_ns = now_ns;
  const bool again = waiting_.contains({host, number}) || answered_.contains({host, number});
  if (again) return;
  Waiting& waiting = waiting_[{host, number}];
  waiting = {now_ns, MostSeconds(request), std::holds_alternative<RetraceRequest>(request)};
  if (std::holds_alternative<EmergencyStopRequest>(request) && !refused) OnStop(true, now_ns);
  if (std::holds_alternative<ResumeRequest>(request) && !refused) OnStop(false, now_ns);
  if (!TakesHand(request) || refused) return;
  if (stop_) violations_->Add("something is taken during an emergency stop", id_);
  const bool in_use = owner_ != 0 && owner_ != host && Silence(now_ns) < 0.4 &&
                      now_ns - owner_ns_ > kLooksNs && held_ns_ != 0 &&
                      now_ns - held_ns_ > kLooksNs && now_ns - woken_ns_ > kLooksNs;
  if (in_use && !device_hand_) violations_->Add("a host takes the hand that another has", id_);
  if (owner_ != host) owner_ns_ = now_ns;
  asked_ns_ = now_ns;
  owner_ = host;
  lost_ns_ = 0;
}

void HostChecker::OnAnswer(HostId host, std::uint64_t number, bool ok, std::int64_t now_ns) {
  static_cast<void>(ok);
  const auto waiting = waiting_.find({host, number});
  if (waiting == waiting_.end()) {
    violations_->Add(answered_.contains({host, number}) ? "a request has two answers"
                                                        : "an answer to what nobody asked",
                     id_, Text("number %llu", static_cast<unsigned long long>(number)));
    return;
  }
  if (waiting->second.back) back_ns_ = now_ns;
  waiting_.erase(waiting);
  answered_.insert({host, number});
}

void HostChecker::OnStop(bool stop, std::int64_t now_ns) {
  if (stop && !stop_) stopped_ns_ = now_ns;
  stop_ = stop;
}

void HostChecker::OnWoken(std::int64_t halted_ns, std::int64_t now_ns) {
  woken_ns_ = now_ns;
  for (auto& [requested, waiting] : waiting_) waiting.since_ns += halted_ns;
  // a rate lasts for a number of frames
  for (auto& [id, host] : hosts_) host.moved_ns += halted_ns;
}

void HostChecker::Lose(HostId host, std::int64_t now_ns) {
  hosts_.erase(host);
  if (owner_ != host) return;
  owner_ = 0;
  lost_ns_ = now_ns;
}

double HostChecker::Silence(std::int64_t now_ns) const {
  const auto owner = hosts_.find(owner_);
  // a controller that stood still gets the messages of that time when it is woken
  return owner == hosts_.end() ? 0 : ToSeconds(now_ns - owner->second.received_ns);
}

void HostChecker::Check(const HandObservation& sight, double way_m, double speed) {
  if (sight.held < 0) {
    held_ns_ = 0;
  } else if (held_ns_ == 0 || (before_ && before_->held != sight.held)) {
    held_ns_ = sight.now_ns;
  }
  const bool same = before_ && before_->attached && sight.attached && before_->held == sight.held;
  if (!same) grasped_ns_ = sight.now_ns;
  CheckAnswers(sight, way_m);
  CheckStop(sight);
  if (!device_hand_) {
    CheckSilence(sight, speed);
    CheckGoal(sight);
    CheckNewestGoal(sight);
  }
  before_ = sight;
}

void HostChecker::CheckAnswers(const HandObservation& sight, double way_m) {
  for (const auto& [requested, waiting] : waiting_) {
    if (waiting.back) back_ns_ = sight.now_ns;
    const double most_s = waiting.most_s + (waiting.back ? way_m / kWayBackSpeed + 10 : 0);
    const double waits_s = ToSeconds(sight.now_ns - waiting.since_ns);
    if (waits_s <= most_s) continue;
    violations_->Add(
        "a request has no answer", id_,
        Text("number %llu for %.2f s", static_cast<unsigned long long>(requested.second), waits_s));
  }
}

void HostChecker::CheckStop(const HandObservation& sight) {
  if (!stop_ || sight.now_ns - std::max(stopped_ns_, woken_ns_) < kLooksNs) return;
  if (sight.held >= 0 || sight.wanted >= 0) {
    violations_->Add("a part is in hand during an emergency stop", id_);
  }
}

void HostChecker::CheckSilence(const HandObservation& sight, double speed) {
  const std::int64_t now_ns = sight.now_ns;
  if (woken_ns_ != 0 && now_ns - woken_ns_ < kFewFrames) return;  // it reads its messages first
  for (auto host = hosts_.begin(); host != hosts_.end();) {
    const auto next = std::next(host);
    if (now_ns - host->second.received_ns > kLostNs) Lose(host->first, now_ns);
    host = next;
  }
  if (sight.held < 0 && sight.wanted < 0) lost_ns_ = 0;
  if (lost_ns_ != 0 && now_ns - std::max(lost_ns_, woken_ns_) > kLostAgoNs) {
    violations_->Add("a hand holds on though its host is gone", id_);
    lost_ns_ = 0;
  }
  // by then the goal is held, and has been for too short a time to drift
  const double silent_s = Silence(now_ns);
  const bool judged = silent_s > 0.18 && silent_s < 0.19 && now_ns - grasped_ns_ > 2 * kLooksNs &&
                      now_ns - woken_ns_ > 2 * kLooksNs && now_ns - back_ns_ > 2 * kLooksNs;
  if (!judged || !sight.attached || sight.led) return;
  const double ahead = (sight.requested.p - sight.handle.p).norm();
  if (ahead > 0.05 * speed + 2e-3) {
    violations_->Add("the goal of a silent host is not held", id_, Text("%.1f mm", 1e3 * ahead));
  }
}

bool HostChecker::MayMove(const HandObservation& sight) const {
  const std::int64_t now_ns = sight.now_ns;
  if (now_ns - grasped_ns_ < kLooksNs || now_ns - back_ns_ < kLooksNs) return true;
  if (now_ns - woken_ns_ < kLooksNs || now_ns - owner_ns_ < kLooksNs) return true;
  const auto owner = hosts_.find(owner_);
  if (owner == hosts_.end()) return lost_ns_ != 0;
  if (now_ns <= owner->second.moved_ns) return true;
  const std::int64_t silent_ns = now_ns - owner->second.received_ns;
  return silent_ns >= kQuietNs && silent_ns < kQuietNs + kLooksNs;
}

void HostChecker::CheckGoal(const HandObservation& sight) {
  const Pose& requested = sight.requested;
  if (!IsSound(requested.p)) {
    violations_->Add("a goal that is no place is gone to", id_);
    return;
  }
  const bool moved = before_ && before_->attached && sight.attached &&
                     before_->held == sight.held && !SamePlace(before_->requested, requested);
  if (!moved) return;
  if (!MayMove(sight)) {
    violations_->Add(
        "a goal moves without a word of its host", id_,
        Text("by %.2f mm, its host silent for %.3f s",
             1e3 * (requested.p - before_->requested.p).norm(), Silence(sight.now_ns)));
  }
  const auto owner = hosts_.find(owner_);
  const bool own = owner != hosts_.end() && owner->second.stated &&
                   SamePlace(*owner->second.stated, requested);  // both hosts may have sent the
                                                                 // pose of a body
  for (const auto& [host, known] : hosts_) {
    if (own || host == owner_ || !known.stated || !SamePlace(*known.stated, requested)) continue;
    if (sight.now_ns - owner_ns_ < kLooksNs) continue;
    // a way back ends where the part was taken, which another host may have asked for too
    if (sight.now_ns - back_ns_ < kLooksNs) continue;
    violations_->Add("a hand follows a host that does not have it", id_,
                     "that is host " + std::to_string(host) + ", not " + std::to_string(owner_));
  }
}

void HostChecker::CheckNewestGoal(const HandObservation& sight) {
  const auto owner = hosts_.find(owner_);
  if (owner == hosts_.end() || !owner->second.stated || !sight.attached || sight.led) return;
  const std::int64_t now_ns = sight.now_ns;
  const std::int64_t said_ns = owner->second.said_ns;
  const bool judged = said_ns > asked_ns_ && now_ns - said_ns > kFewFrames &&
                      now_ns - owner->second.received_ns < kQuietNs - kLooksNs &&
                      now_ns >= owner->second.moved_ns && now_ns - grasped_ns_ > kLooksNs &&
                      now_ns - woken_ns_ > kLooksNs && back_ns_ < said_ns;
  if (!judged || SamePlace(*owner->second.stated, sight.requested)) return;
  violations_->Add("the goal of the host that has the hand is not gone to", id_,
                   Text("%.2f mm", 1e3 * (owner->second.stated->p - sight.requested.p).norm()));
}

}  // namespace tandem
