#include <algorithm>
#include <iterator>

#include "collab/controller/hand_task.h"
#include "engine/haptics/path_backtracker.h"

// Leads all bodies to their first places, one after the other, along the ways on which they were
// seen to leave (BodyTrails). A body that something blocks is tried again when another one has
// arrived, since that one may have been in its way.

namespace tandem {

namespace {

constexpr std::int64_t kStuckNs = 2'000'000'000;  // without a step of the goal
constexpr std::int64_t kSettleNs = 500'000'000;   // at the first place
constexpr std::int64_t kLongestStepNs = 50'000'000;
constexpr std::size_t kMostNamed = 5;  // bodies that an answer names

}  // namespace

std::string HandTask::WhyNotLed(int moving, const SimulationFacts& facts,
                                const ControlScene& scene) const {
  const SimulationFacts::Body& fact = facts.bodies[static_cast<std::size_t>(moving)];
  const auto body = static_cast<std::size_t>(scene.BodyOfMoving(moving));
  if (scene.bodies[body].shared && scene.own_only) {
    return "this peer has other force parameters (--insist) and cannot hold it";
  }
  for (std::uint32_t i = 0; i < fact.holder_count; ++i) {
    const PeerId holder = fact.holders[i];
    if (holder == scene.self) continue;
    const auto peer = std::ranges::find(peers_, holder, &SnapshotPeer::id);
    return peer == peers_.end() ? "another user holds it" : peer->name + " holds it";
  }
  return {};
}

void HandTask::TakeNextHome(const SimulationFacts& facts, const ControlScene& scene,
                            std::int64_t now_ns) {
  if (!facts.goal_device) {
    return End({false, "a device moves the hand: move the body back with the device"});
  }
  if (!std::exchange(reset_.begun, true)) {
    for (const int moving : trails_.Displaced()) reset_.left.push_back(moving);
    // the hand is emptied first, with no word on what it holds
    if (facts.held >= 0 || facts.wanted >= 0) {
      Order(Command::Kind::kRelease);
      return Enter(Step::kSetting, now_ns);
    }
  }
  if (reset_.left.empty() && std::exchange(reset_.progress, false)) {
    reset_.left.assign(reset_.failed.begin(), reset_.failed.end());
    reset_.failed.clear();
  }
  while (!reset_.left.empty()) {
    moving_ = reset_.left.front();
    reset_.left.pop_front();
    const int body = scene.BodyOfMoving(moving_);
    if (body < 0) continue;
    if (std::string why = WhyNotLed(moving_, facts, scene); !why.empty()) {
      reset_.why[moving_] = std::move(why);
      reset_.failed.push_back(moving_);
      continue;
    }
    object_ = scene.bodies[static_cast<std::size_t>(body)].object;
    order_.void_seq = order_.input_seq;
    order_.at_centre = true;
    return Aim(false, Step::kTaking, now_ns);
  }
  EndReset(scene, now_ns);
}

void HandTask::BeginLeading(const SimulationFacts& facts, std::int64_t now_ns) {
  const Pose& X_WB = facts.bodies[static_cast<std::size_t>(moving_)].X_WB;
  reset_.way = trails_.way(moving_);
  reset_.next = reset_.way.size();
  reset_.goal = X_WB;
  reset_.X_BG = X_WB.Inverse() * facts.X_WG;
  reset_.led_ns = reset_.stepped_ns = now_ns;
  Enter(Step::kLeading, now_ns);
}

void HandTask::Lead(const SimulationFacts& facts, const ControlScene& scene, std::int64_t now_ns) {
  if (facts.held != moving_) return SetDown("another hand has taken it", now_ns);
  const Pose& X_WB = facts.bodies[static_cast<std::size_t>(moving_)].X_WB;
  const std::int64_t passed_ns =
      std::min(now_ns - std::exchange(reset_.led_ns, now_ns), kLongestStepNs);
  double left = 1e-9 * static_cast<double>(passed_ns) * PathBacktracker::kSpeed;
  // the goal goes on along the way, and is never far ahead of the body
  while (left > 0 && reset_.next > 0 &&
         trails_.Travel(moving_, reset_.goal, X_WB) < PathBacktracker::kLead) {
    reset_.stepped_ns = now_ns;
    const Pose& ahead = reset_.way[reset_.next - 1];
    const double travel = trails_.Travel(moving_, reset_.goal, ahead);
    const double share = travel > left ? left / travel : 1.0;
    reset_.goal = {reset_.goal.q.slerp(share, ahead.q),
                   reset_.goal.p + share * (ahead.p - reset_.goal.p)};
    left -= travel;
    if (share >= 1.0) --reset_.next;
  }
  ++order_.input_seq;
  order_.input = GoalOrder::Input::kPose;
  order_.X_WG = reset_.goal * reset_.X_BG;
  peer_->Tell(order_);
  // a body that friction or weight keeps from settling arrives after a while too
  const std::int64_t waited_ns = now_ns - reset_.stepped_ns;
  const double away = trails_.Travel(moving_, reset_.way.front(), X_WB);
  const bool settled =
      away < PathBacktracker::kSettled || (waited_ns > kSettleNs && away < PathBacktracker::kThere);
  if (reset_.next == 0 && settled) return SetDown({}, now_ns);
  if (waited_ns < kStuckNs) return;
  const std::span contacts(facts.contacts.data(), facts.contact_count);
  const auto hardest = std::ranges::max_element(contacts, {}, &SimulationFacts::ContactFact::force);
  std::string what = "something";
  if (hardest != contacts.end()) {
    const int other = hardest->other;
    const auto fixed = std::ranges::find(scene.bodies, true, &ControlScene::Body::fixed);
    const bool one_fixed = std::ranges::count(scene.bodies, true, &ControlScene::Body::fixed) == 1;
    what = other >= 0 ? NameOf(scene, other) : one_fixed ? fixed->name : "a fixed body";
  }
  SetDown(what + " is in its way", now_ns);
}

void HandTask::SetDown(const std::string& why, std::int64_t now_ns) {
  if (why.empty()) {
    ++parts_;
    reset_.progress = true;
    reset_.why.erase(moving_);
  } else {
    reset_.why[moving_] = why;
    reset_.failed.push_back(moving_);
  }
  Enter(Step::kSetting, now_ns);
  Order(Command::Kind::kRelease);
}

void HandTask::EndReset(const ControlScene& scene, std::int64_t now_ns) {
  std::string& words = reset_.words;
  words = std::to_string(parts_) + (parts_ == 1 ? " body" : " bodies") + " went back";
  std::size_t named = 0;
  for (const auto& [moving, why] : reset_.why) {
    if (named++ == kMostNamed) {
      words += "; nor did " + std::to_string(reset_.why.size() - kMostNamed) + " more";
      break;
    }
    words += "; " + NameOf(scene, moving) + " did not: " + why;
  }
  if (!reset_.why.empty()) return End({false, words});
  Enter(Step::kForgetting, now_ns);
}

void HandTask::ForgetWays(const SimulationFacts& facts, std::int64_t now_ns) {
  const bool is_late = now_ns - since_ns_ > kStepNs;
  if (is_late || (facts.way_seq == order_.way_seq && facts.way_body < 0)) {
    return End({true, reset_.words});
  }
  if (facts.way_seq == order_.way_seq) TellWay(GoalOrder::Way::kDrop);
}

}  // namespace tandem
