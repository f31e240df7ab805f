#include "collab/controller/control_server.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collab/controller/plain.h"

namespace tandem {

ControlServer::ControlServer(ControlledPeer& peer, bool device_hand)
    : peer_(&peer), device_hand_(device_hand), task_(peer) {}

ControlServer::Host* ControlServer::HostOf(HostId id, std::int64_t now_ns) {
  if (id == 0) return nullptr;
  const auto known = hosts_.find(id);
  if (known == hosts_.end() && hosts_.size() >= kMostHosts) return nullptr;
  Host& host = hosts_[id];
  host.received_ns = now_ns;
  return &host;
}

void ControlServer::Reply(HostId host, std::uint64_t number, const Answer& answer) {
  answers_.push_back({host, number, answer});
}

void ControlServer::OnScene(std::optional<ControlScene> scene, std::int64_t now_ns) {
  task_.End({false, "another scene has replaced the one whose body was in hand"});
  AnswerTasks();
  if (scene_) old_scene_ = *scene_;
  scene_ = std::move(scene);
  facts_ = {};
  facts_.time_ns = now_ns;
  distance_held_ = -1;
}

void ControlServer::OnGoal(HostId id, const HostGoal& goal, std::int64_t now_ns) {
  if (goal.kind == HostGoal::Kind::kGoodbye) return Lose(id, "has left", now_ns);
  Host* host = HostOf(id, now_ns);
  if (host == nullptr) return;
  const bool newer = goal.seq > host->goal_seq;
  host->goal_seq = std::max(host->goal_seq, goal.seq);
  if (device_hand_ || stopped_ || !scene_) return;
  // the first host with a goal leads a part that the peer's own command line put into the hand
  const bool nobodys = hand_host_ == 0 && facts_.held >= 0 && !lets_go_;
  if (nobodys && newer && goal.kind != HostGoal::Kind::kBeat) {
    TakeHand(id);
    void_seq_ = goal.seq - 1;
  }
  if (id != hand_host_) return;
  // after a silence the goal that was held still counts again
  const bool again = std::exchange(held_still_, false) && goal.seq == host->goal_seq &&
                     goal.kind == HostGoal::Kind::kPose;
  if (goal.kind == HostGoal::Kind::kBeat || goal.seq <= void_seq_ || !(newer || again)) return;
  const bool turns = std::abs(goal.X_WG.q.norm() - 1.0) <= 1e-3;
  if (!turns || !AllFinite(goal.X_WG.p) || !AllFinite(goal.linear) || !AllFinite(goal.angular))
    return;
  const auto input = goal.kind == HostGoal::Kind::kPose   ? GoalOrder::Input::kPose
                     : goal.kind == HostGoal::Kind::kRate ? GoalOrder::Input::kRate
                                                          : GoalOrder::Input::kPush;
  const Pose X_WG{goal.X_WG.q.normalized(), goal.X_WG.p};
  task_.SetGoal(input, X_WG, goal.linear, goal.angular);
  AnswerTasks();
}

void ControlServer::OnFacts(const SimulationFacts& facts, std::int64_t now_ns) {
  if (!scene_) return;
  facts_ = facts;
  // a release finds no room where the simulation stands still: it is repeated until it is done
  if (facts.held < 0 && facts.wanted < 0) lets_go_ = false;
  if (lets_go_) peer_->Order({.kind = Command::Kind::kRelease});
  task_.OnFacts(facts, *scene_, now_ns);
  AnswerTasks();
}

void ControlServer::OnNews(const Notification& news, const std::string& line) {
  if (scene_) task_.OnNews(news, line, *scene_);
  AnswerTasks();
  OnLine(line);
  if (news.kind == Notification::Kind::kAsked && news.object < scene_bodies()) {
    asked_ = {news.peer, news.object};
  }
}

void ControlServer::OnLine(const std::string& line) {
  notifications_ = line;
  asked_.reset();
  ++news_count_;
}

void ControlServer::Stop() {
  task_.End({false, "emergency stop"});
  AnswerTasks();
  if (!std::exchange(stopped_, true)) {
    OnLine("emergency stop: the hand lets go and takes no body until it is resumed");
  }
  peer_->StopDevice(true);
  LetGo();
}

void ControlServer::LetGo() {
  lets_go_ = facts_.held >= 0 || facts_.wanted >= 0;
  peer_->Order({.kind = Command::Kind::kRelease});
}

void ControlServer::Resume() {
  if (std::exchange(stopped_, false)) OnLine("the hand may take bodies again");
  peer_->StopDevice(false);
}

void ControlServer::OnDone(std::uint64_t job, const Answer& answer) {
  const auto found = jobs_.find(job);
  if (found == jobs_.end()) return;
  Reply(found->second.host, found->second.number, answer);
  jobs_.erase(found);
}

void ControlServer::AnswerTasks() {
  while (const std::optional<HandTask::Ended> ended = task_.TakeEnded()) {
    const auto task = tasks_.find(ended->tag);
    if (task == tasks_.end()) continue;
    Reply(task->second.host, task->second.number, *ended);
    tasks_.erase(task);
  }
}

void ControlServer::TakeHand(HostId host) {
  lets_go_ = false;
  hand_host_ = host;
  held_still_ = false;
  const auto known = hosts_.find(host);
  void_seq_ = known == hosts_.end() ? 0 : known->second.goal_seq;
}

void ControlServer::Lose(HostId id, const std::string& how, std::int64_t now_ns) {
  const auto lost = hosts_.find(id);
  if (lost == hosts_.end()) return;
  const std::string name = lost->second.name.empty() ? "?" : lost->second.name;
  hosts_.erase(lost);
  if (id == clutch_host_) {
    clutch_host_ = 0;
    ChangeWorkspace({.clutch = false});
  }
  if (id != hand_host_) return;
  hand_host_ = 0;
  held_still_ = false;
  if (device_hand_ || !scene_ || (facts_.held < 0 && !task_.busy())) return;
  task_.LetGo(now_ns);
  lets_go_ = true;
  AnswerTasks();
  lines_.push_back("the host '" + name + "' " + how + ": the hand lets go");
  OnLine(lines_.back());
}

void ControlServer::Tick(std::int64_t now_ns) {
  std::vector<HostId> lost;
  for (const auto& [id, host] : hosts_) {
    if (now_ns - host.received_ns > kLostNs) lost.push_back(id);
  }
  for (const HostId id : lost) Lose(id, "is gone", now_ns);
  const auto hand = hosts_.find(hand_host_);
  if (hand == hosts_.end() || held_still_ || device_hand_) return;
  if (now_ns - hand->second.received_ns <= kQuietNs || !facts_.attached || task_.going_back())
    return;
  held_still_ = true;
  task_.Hold(facts_.handle);
}

std::vector<HostAnswer> ControlServer::TakeAnswers() {
  return std::exchange(answers_, {});
}

std::vector<std::string> ControlServer::TakeLines() {
  return std::exchange(lines_, {});
}

double ControlServer::rate_hz() const {
  double most = 0;
  for (const auto& [id, host] : hosts_) most = std::max(most, host.rate_hz);
  return most;
}

}  // namespace tandem
