#include "collab/separation/instance_separation.h"

#include <algorithm>
#include <utility>

#include "engine/world/world.h"

namespace tandem {

namespace {

constexpr double kNoCap = 1e30;

bool AnyShared(const WorldModel& model) {
  return model.has_fixture &&
         std::any_of(model.object.begin(), model.object.end(), [&model](ObjectId object) {
           return model.scene.bodies[object].shared;
         });
}

}  // namespace

InstanceSeparation::InstanceSeparation(PeerId self, const WorldModel& model)
    : self_(self), model_(&model), detector_(model), history_(AnyShared(model)) {}

void InstanceSeparation::Begin(int body) noexcept {
  body_ = body;
  frames_ = 0;
  trapped_ = false;
  apart_ = false;
  requested_by_user_ = false;
  requested_by_peer_ = false;
  reported_.Clear();
  given_up_ = 0;
  apart_since_ns_ = 0;
  phase_ = Phase::kInHand;
  hand_share_ = 1;
  return_path_.Stop();
  history_.Forget();
  if (body >= 0) detector_.Begin(static_cast<std::size_t>(body));
}

void InstanceSeparation::Tell(Notification::Kind kind, PeerId peer) noexcept {
  if (news_count_ == notifications_.size()) return;
  notifications_[news_count_++] = {kind, model_->object[static_cast<std::size_t>(body_)], peer};
}

bool InstanceSeparation::TakeNotifications(Notification& notification) noexcept {
  if (news_count_ == 0) return false;
  notification = notifications_[0];
  std::move(notifications_.begin() + 1, notifications_.end(), notifications_.begin());
  --news_count_;
  return true;
}

void InstanceSeparation::Keep(const RigidState& own,
                              const std::array<InstanceView, kMaxLinks>& others,
                              std::size_t count) noexcept {
  if (frames_++ % PoseHistory::kPeriod != 0) return;
  PoseHistory::Moment& moment = history_.Add();
  moment.ours = own.X_WB;
  moment.count = count;
  for (std::size_t i = 0; i < count; ++i) {
    moment.others[i] = others[i];
    moment.blocked[i] = detector_.blocked(others[i].peer);
  }
}

void InstanceSeparation::Update(std::int64_t now_ns, const RigidState& own,
                                SharedBody& shared) noexcept {
  if (!history_.used() || body_ < 0) return;
  std::array<InstanceView, kMaxLinks> others;
  const std::size_t count = shared.Instances(others);
  detector_.Update(now_ns, own.X_WB, others.data(), count);
  Keep(own, others, count);

  trapped_ = false;
  apart_ = false;
  PeerId lowest = self_;
  PeerSet<kMaxLinks> still;
  for (std::size_t i = 0; i < count; ++i) {
    const PeerId peer = others[i].peer;
    lowest = std::min(lowest, peer);
    const bool trapped = detector_.trapped(peer);
    const bool known = reported_.Find(peer) != nullptr;
    if (trapped) still.FindOrInsert(peer);
    if (trapped && !known) Tell(Notification::Kind::kApart, peer);
    if (!trapped && known) Tell(Notification::Kind::kTogether, peer);
    trapped_ = trapped_ || trapped;
    apart_ = apart_ || detector_.blocked(peer);
    if (phase_ == Phase::kReleasing || phase_ == Phase::kGuiding) {
      // as the hand does, or the link would draw the body onto the obstacle
      shared.FadeForce(peer, hand_share_);
    } else {
      shared.CapForce(peer, trapped || phase_ != Phase::kInHand ? kMostForce : kNoCap);
    }
  }
  reported_ = still;
  if (phase_ == Phase::kGuiding) return_path_.Advance(history_, own.X_WB);
  Reunite(now_ns, lowest);
}

bool InstanceSeparation::MayReturn(std::int64_t now_ns) noexcept {
  paid_ns_ = std::max(paid_ns_, now_ns);
  if (paid_ns_ - now_ns > kComesAgainNs) return false;
  paid_ns_ += kComesAgainNs;
  return true;
}

void InstanceSeparation::Reunite(std::int64_t now_ns, PeerId lowest) noexcept {
  const bool by_user = std::exchange(requested_by_user_, false);
  const bool requested = std::exchange(requested_by_peer_, false) || by_user;
  if (phase_ == Phase::kReleasing || phase_ == Phase::kGuiding) return;
  if (return_path_.state() == ReturnPath::State::kSearching) return SearchPath(lowest);
  if (lowest == self_ || !detector_.trapped(lowest)) {
    apart_since_ns_ = 0;
    given_up_ = 0;
    const bool wanted = requested && lowest != self_ && detector_.blocked(lowest);
    if (!wanted) return;
  } else if (apart_since_ns_ == 0) {
    apart_since_ns_ = now_ns;
  }
  const bool waited = apart_since_ns_ != 0 && now_ns - apart_since_ns_ >= kPatienceNs;
  if (!requested && (!waited || given_up_ == lowest)) return;
  if (!by_user && !MayReturn(now_ns)) return;
  return_path_.Start(history_, lowest, body().radius);
  SearchPath(lowest);
}

void InstanceSeparation::SearchPath(PeerId lowest) noexcept {
  if (return_path_.towards() != lowest ||
      !(detector_.blocked(lowest) || detector_.trapped(lowest))) {
    return_path_.Stop();  // the way is not wanted any more
    return;
  }
  return_path_.Search(history_);
  if (return_path_.state() == ReturnPath::State::kFound) {
    Tell(Notification::Kind::kComingBack, lowest);
    phase_ = Phase::kReleasing;
  } else if (return_path_.state() == ReturnPath::State::kNoWay) {
    given_up_ = lowest;
    Tell(Notification::Kind::kNoWayBack, lowest);
  }
}

void InstanceSeparation::GuideHand(const RigidState& own, const Pose& X_WD, Pose& X_BD,
                                   StepInputs::Hand& hand) noexcept {
  if (phase_ == Phase::kInHand) return;
  const bool arrived = return_path_.state() == ReturnPath::State::kArrived;
  if (phase_ == Phase::kReleasing) {
    hand_share_ -= kFrame / kLetGo;
    if (hand_share_ <= 0) {
      phase_ = Phase::kGuiding;
      return_path_.SetOut(history_, own.X_WB);  // the body moved on while the hand let go
    }
  } else if (phase_ == Phase::kGuiding && return_path_.state() != ReturnPath::State::kUnderWay) {
    phase_ = Phase::kRegrasping;
    X_BD = own.X_WB.Inverse() * X_WD;
    hand.X_BD = X_BD;
    if (!arrived) {
      given_up_ = return_path_.towards();
      Tell(Notification::Kind::kNoWayBack, given_up_);
    }
  } else if (phase_ == Phase::kRegrasping) {
    hand_share_ += kFrame / kTakeUp;
    if (hand_share_ >= 1) phase_ = Phase::kInHand;
  }
  hand_share_ = std::clamp(hand_share_, 0.0, 1.0);
  if (phase_ == Phase::kGuiding) {
    hand.X_BD = Pose{};
    hand.gains = ReturnPathGains(body().inertia);
    hand.goal = {return_path_.goal(), {}};
    // so that its weight does not draw it off the way
    hand.goal.X_WA.p -= body().inertia.mass / hand.gains.stiffness * model_->scene.gravity_W;
    return;
  }
  hand.gains.stiffness *= hand_share_;
  hand.gains.damping *= hand_share_;
  hand.gains.rotation_stiffness *= hand_share_;
  hand.gains.rotation_damping *= hand_share_;
}

}  // namespace tandem
