#include "collab/separation/parting.h"

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

Parting::Parting(PeerId self, const WorldModel& model)
    : self_(self), model_(&model), detector_(model), history_(AnyShared(model)) {}

void Parting::Begin(int body) noexcept {
  body_ = body;
  frames_ = 0;
  trapped_ = false;
  apart_ = false;
  asked_ = false;
  asked_by_another_ = false;
  told_.Clear();
  given_up_ = 0;
  apart_since_ns_ = 0;
  phase_ = Phase::kInHand;
  hand_share_ = 1;
  retrace_.Stop();
  history_.Forget();
  if (body >= 0) detector_.Begin(static_cast<std::size_t>(body));
}

void Parting::Tell(HoldingNews::Kind kind, PeerId peer) noexcept {
  if (news_count_ == news_.size()) return;
  news_[news_count_++] = {kind, model_->object[static_cast<std::size_t>(body_)], peer};
}

bool Parting::TakeNews(HoldingNews& news) noexcept {
  if (news_count_ == 0) return false;
  news = news_[0];
  std::move(news_.begin() + 1, news_.end(), news_.begin());
  --news_count_;
  return true;
}

void Parting::Keep(const RigidState& own, const std::array<InstanceView, kMaxLinks>& others,
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

void Parting::Look(std::int64_t now_ns, const RigidState& own, SharedBody& shared) noexcept {
  if (!history_.used() || body_ < 0) return;
  std::array<InstanceView, kMaxLinks> others;
  const std::size_t count = shared.Instances(others);
  detector_.Look(now_ns, own.X_WB, others.data(), count);
  Keep(own, others, count);

  trapped_ = false;
  apart_ = false;
  PeerId lowest = self_;
  PeerSet<kMaxLinks> still;
  for (std::size_t i = 0; i < count; ++i) {
    const PeerId peer = others[i].peer;
    lowest = std::min(lowest, peer);
    const bool trapped = detector_.trapped(peer);
    const bool known = told_.Find(peer) != nullptr;
    if (trapped) still.FindOrInsert(peer);
    if (trapped && !known) Tell(HoldingNews::Kind::kApart, peer);
    if (!trapped && known) Tell(HoldingNews::Kind::kTogether, peer);
    trapped_ = trapped_ || trapped;
    apart_ = apart_ || detector_.blocked(peer);
    if (phase_ == Phase::kLettingGo || phase_ == Phase::kLeading) {
      // as the hand does, or the link would draw the body onto the obstacle
      shared.FadeForce(peer, hand_share_);
    } else {
      shared.CapForce(peer, trapped || phase_ != Phase::kInHand ? kMostForce : kNoCap);
    }
  }
  told_ = still;
  if (phase_ == Phase::kLeading) retrace_.Advance(history_, own.X_WB);
  Heal(now_ns, lowest);
}

bool Parting::MayCome(std::int64_t now_ns) noexcept {
  paid_ns_ = std::max(paid_ns_, now_ns);
  if (paid_ns_ - now_ns > kComesAgainNs) return false;
  paid_ns_ += kComesAgainNs;
  return true;
}

void Parting::Heal(std::int64_t now_ns, PeerId lowest) noexcept {
  const bool by_user = std::exchange(asked_, false);
  const bool asked = std::exchange(asked_by_another_, false) || by_user;
  if (phase_ == Phase::kLettingGo || phase_ == Phase::kLeading) return;
  if (retrace_.state() == Retrace::State::kSearching) return Seek(lowest);
  if (lowest == self_ || !detector_.trapped(lowest)) {
    apart_since_ns_ = 0;
    given_up_ = 0;
    const bool wanted = asked && lowest != self_ && detector_.blocked(lowest);
    if (!wanted) return;
  } else if (apart_since_ns_ == 0) {
    apart_since_ns_ = now_ns;
  }
  const bool waited = apart_since_ns_ != 0 && now_ns - apart_since_ns_ >= kPatienceNs;
  if (!asked && (!waited || given_up_ == lowest)) return;
  if (!by_user && !MayCome(now_ns)) return;
  retrace_.Start(history_, lowest, body().radius);
  Seek(lowest);
}

void Parting::Seek(PeerId lowest) noexcept {
  if (retrace_.towards() != lowest || !(detector_.blocked(lowest) || detector_.trapped(lowest))) {
    retrace_.Stop();  // the way is not wanted any more
    return;
  }
  retrace_.Search(history_);
  if (retrace_.state() == Retrace::State::kFound) {
    Tell(HoldingNews::Kind::kComingBack, lowest);
    phase_ = Phase::kLettingGo;
  } else if (retrace_.state() == Retrace::State::kNoWay) {
    given_up_ = lowest;
    Tell(HoldingNews::Kind::kNoWayBack, lowest);
  }
}

void Parting::Lead(const RigidState& own, const Pose& X_WD, Pose& X_BD,
                   StepInputs::Hand& hand) noexcept {
  if (phase_ == Phase::kInHand) return;
  const bool arrived = retrace_.state() == Retrace::State::kArrived;
  if (phase_ == Phase::kLettingGo) {
    hand_share_ -= kFrame / kLetGo;
    if (hand_share_ <= 0) {
      phase_ = Phase::kLeading;
      retrace_.SetOut(history_, own.X_WB);  // the body moved on while the hand let go
    }
  } else if (phase_ == Phase::kLeading && retrace_.state() != Retrace::State::kUnderWay) {
    phase_ = Phase::kTakingUp;
    X_BD = own.X_WB.Inverse() * X_WD;
    hand.X_BD = X_BD;
    if (!arrived) {
      given_up_ = retrace_.towards();
      Tell(HoldingNews::Kind::kNoWayBack, given_up_);
    }
  } else if (phase_ == Phase::kTakingUp) {
    hand_share_ += kFrame / kTakeUp;
    if (hand_share_ >= 1) phase_ = Phase::kInHand;
  }
  hand_share_ = std::clamp(hand_share_, 0.0, 1.0);
  if (phase_ == Phase::kLeading) {
    hand.X_BD = Pose{};
    hand.gains = RetraceGains(body().inertia);
    hand.goal = {retrace_.goal(), {}};
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
