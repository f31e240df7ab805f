#include "collab/controller/hand_task.h"

#include <utility>

namespace tandem {

std::optional<HandTask::Ended> HandTask::TakeEnded() {
  if (ended_.empty()) return std::nullopt;
  const Ended ended = ended_.front();
  ended_.pop_front();
  return ended;
}

void HandTask::End(const Answer& answer) {
  if (step_ == Step::kNone) return;
  step_ = Step::kNone;
  back_ = false;
  ended_.push_back({answer, tag_});
}

void HandTask::Begin(Step step, std::int64_t now_ns) {
  End({false, "another request for the hand has replaced this one"});
  back_ = false;
  reset_ = {};
  tag_ = std::exchange(next_tag_, 0);
  Enter(step, now_ns);
}

void HandTask::Enter(Step step, std::int64_t now_ns) {
  step_ = step;
  since_ns_ = now_ns;
}

bool HandTask::Order(Command::Kind kind, ObjectId object, PeerId to) {
  if (peer_->Order({.kind = kind, .object = object, .to = to})) return true;
  End({false, "too many commands at once: ask again"});
  return false;
}

void HandTask::Aim(bool keeps_way, Step then, std::int64_t now_ns) {
  ++order_.grasp_seq;
  order_.body = moving_;
  order_.keeps_way = keeps_way;
  if (keeps_way) order_.at_centre = true;
  peer_->Tell(order_);
  then_ = then;
  Enter(Step::kAiming, now_ns);
}

void HandTask::TellWay(GoalOrder::Way way) {
  ++order_.way_seq;
  order_.way = way;
  peer_->Tell(order_);
}

void HandTask::Take(int moving, const GrabRequest& request, const ControlScene& scene,
                    std::int64_t now_ns) {
  Begin(Step::kFreeing, now_ns);
  then_ = Step::kTaking;
  order_.void_seq = order_.input_seq;
  moving_ = moving;
  object_ = scene.bodies[static_cast<std::size_t>(scene.BodyOfMoving(moving))].object;
  order_.at_centre = !request.grasp_W.has_value();
  if (request.grasp_W) {
    const auto& p = *request.grasp_W;
    order_.p_WG = Vec3(p[0], p[1], p[2]);
  }
}

void HandTask::AskFor(int moving, const ControlScene& scene, std::int64_t now_ns) {
  Take(moving, {}, scene, now_ns);
  then_ = Step::kAsking;
}

void HandTask::LetGo(std::int64_t now_ns) {
  Begin(Step::kLeaving, now_ns);
  TellWay(GoalOrder::Way::kNone);
  Order(Command::Kind::kRelease);
}

void HandTask::Give(PeerId to, std::int64_t now_ns) {
  Begin(Step::kGiving, now_ns);
  Order(Command::Kind::kGive, kNoObject, to);
}

void HandTask::GoBack(RetraceRequest::To to, std::int64_t now_ns) {
  Begin(Step::kDropping, now_ns);  // no way has to be forgotten yet
  back_ = true;
  to_ = to;
  moving_ = -1;
  parts_ = 0;
  stopped_by_.clear();
}

void HandTask::SetGoal(GoalOrder::Input input, const Pose& X_WG, const Vec3& linear,
                       const Vec3& angular) {
  if (going_back()) End({false, "a new goal has stopped the way back"});
  ++order_.input_seq;
  order_.input = input;
  order_.X_WG = X_WG;
  order_.linear = linear;
  order_.angular = angular;
  peer_->Tell(order_);
}

void HandTask::Hold(const Pose& X_WG) {
  SetGoal(GoalOrder::Input::kPose, X_WG, Vec3::Zero(), Vec3::Zero());
}

std::string HandTask::NameOf(const ControlScene& scene, int moving) const {
  const int body = scene.BodyOfMoving(moving);
  return body < 0 ? "the part" : scene.bodies[static_cast<std::size_t>(body)].name;
}

void HandTask::OnFacts(const SimulationFacts& facts, const ControlScene& scene,
                       std::int64_t now_ns) {
  trails_.See(facts, scene);
  const std::int64_t waited_ns = now_ns - since_ns_;
  const bool in_hand = facts.held == moving_ && facts.attached &&
                       (!facts.goal_device || facts.grasp_seq == order_.grasp_seq);
  switch (step_) {
    case Step::kNone:
      return;
    case Step::kFreeing:
      if (facts.held >= 0 || facts.wanted >= 0) {
        // repeated in each frame until it is done: a release that is not due does no harm
        Order(Command::Kind::kRelease);
        if (waited_ns > kStepNs) End({false, "the hand has not let go of the body it holds"});
        return;
      }
      Aim(false, then_, now_ns);
      return;
    case Step::kAiming:
      if (facts.goal_device && facts.grasp_seq != order_.grasp_seq) {
        if (waited_ns > kStepNs) End({false, "the hand does not answer"});
        return;
      }
      Enter(then_, now_ns);
      Order(Command::Kind::kGrab, object_);
      return;
    case Step::kTaking:
      if (in_hand && back_ && to_ == RetraceRequest::To::kReset) {
        BeginLeading(facts, now_ns);
      } else if (waited_ns > kTakeNs && reset_.begun) {
        SetDown("no peer has granted it", now_ns);
      } else if (in_hand && back_) {
        Enter(Step::kBack, now_ns);
        TellWay(GoalOrder::Way::kBack);
      } else if (in_hand) {
        End({true, ""});
      } else if (waited_ns > kTakeNs) {
        End({false, "no peer has granted " + NameOf(scene)});
      }
      return;
    case Step::kAsking:
      if (in_hand) End({true, NameOf(scene) + " is in your hand"});
      if (waited_ns > kTakeNs) End({false, "no peer has granted " + NameOf(scene)});
      return;
    case Step::kLeaving:
      if (facts.held < 0 && facts.wanted < 0) End({true, ""});
      if (waited_ns > kStepNs) End({false, "the hand does not let go"});
      return;
    case Step::kGiving:
      if (facts.held < 0) End({true, ""});
      if (waited_ns > kTakeNs) End({false, "the other user has not taken it"});
      return;
    case Step::kBack:
      OnBack(facts, scene, now_ns);
      return;
    case Step::kPutting:
      if (facts.held >= 0) {
        if (waited_ns > kStepNs) End({false, "the hand has not let go of " + NameOf(scene)});
        return;
      }
      if (!keep_way_) TellWay(GoalOrder::Way::kDrop);
      if (!arrived_) return End({false, stopped_by_});
      return End({true, NameOf(scene) + " is back"});
    case Step::kDropping:
      if (waited_ns > kStepNs) return End({false, "the hand does not answer"});
      if (facts.way_seq != order_.way_seq) return;
      if (to_ == RetraceRequest::To::kReset) return TakeNextHome(facts, scene, now_ns);
      return TakeNextWay(facts, scene, now_ns);
    case Step::kLeading:
      return Lead(facts, scene, now_ns);
    case Step::kForgetting:
      return ForgetWays(facts, now_ns);
    case Step::kSetting:
      if (facts.held < 0 && facts.wanted < 0) return TakeNextHome(facts, scene, now_ns);
      Order(Command::Kind::kRelease);
      if (waited_ns > kStepNs) End({false, "the hand has not let go of " + NameOf(scene)});
      return;
  }
}

void HandTask::TakeNextWay(const SimulationFacts& facts, const ControlScene& scene,
                           std::int64_t now_ns) {
  if (!facts.goal_device) {
    return End({false, "a device moves the hand: move the body back with the device"});
  }
  const bool holds = facts.held >= 0 && facts.attached;
  if (to_ == RetraceRequest::To::kGrasp && !holds) return End({false, "the hand is empty"});
  if (holds) {
    moving_ = facts.held;
    Enter(Step::kBack, now_ns);
    TellWay(GoalOrder::Way::kBack);
    return;
  }
  if (facts.way_body < 0) return End({false, "there is nothing to undo"});
  order_.void_seq = order_.input_seq;
  moving_ = facts.way_body;
  object_ = scene.bodies[static_cast<std::size_t>(scene.BodyOfMoving(moving_))].object;
  Aim(true, Step::kTaking, now_ns);
}

void HandTask::OnBack(const SimulationFacts& facts, const ControlScene& scene,
                      std::int64_t now_ns) {
  if (facts.held != moving_) return End({false, NameOf(scene) + " is no longer in your hand"});
  if (facts.way_seq != order_.way_seq || facts.way == PathBacktracker::State::kUnderWay) return;
  arrived_ = facts.way == PathBacktracker::State::kArrived;
  keep_way_ = facts.way == PathBacktracker::State::kStuck;
  const bool cut = facts.way == PathBacktracker::State::kCut;
  stopped_by_ =
      NameOf(scene) +
      (keep_way_ ? " stopped on its way back: something blocks it"
       : cut     ? " went back as far as its path is known; the whole path was too long to keep"
                 : " is not where its path ends: something has moved it since");
  if (to_ == RetraceRequest::To::kGrasp) {
    return End(arrived_ ? Answer{true, ""} : Answer{false, stopped_by_});
  }
  Enter(Step::kPutting, now_ns);
  Order(Command::Kind::kRelease);
}

void HandTask::OnNews(const Notification& news, const std::string& line,
                      const ControlScene& scene) {
  if (news.object != object_) return;
  const bool taking = step_ == Step::kTaking || step_ == Step::kAsking;
  if (reset_.begun && back_) {
    const bool refused =
        news.kind == Notification::Kind::kRefused || news.kind == Notification::Kind::kNoAnswer;
    const bool lost = news.kind == Notification::Kind::kTaken;
    if ((step_ == Step::kTaking && refused) || (step_ == Step::kLeading && lost)) {
      SetDown(line, since_ns_);
    }
    return;
  }
  switch (news.kind) {
    case Notification::Kind::kRefused:
      if (taking) End({step_ == Step::kAsking, line});
      return;
    case Notification::Kind::kNoAnswer:
      if (taking) End({false, line});
      return;
    case Notification::Kind::kTaken:
      if (step_ == Step::kBack) End({false, line});
      return;
    default:
      static_cast<void>(scene);
      return;
  }
}

}  // namespace tandem
