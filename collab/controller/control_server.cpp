#include "collab/controller/control_server.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "collab/controller/plain.h"

namespace tandem {

namespace {

bool IsSlow(const ControlRequest& request) {
  return std::holds_alternative<LoadSceneRequest>(request) ||
         std::holds_alternative<LoadMeshRequest>(request) ||
         std::holds_alternative<VoxelizeRequest>(request) ||
         std::holds_alternative<MeasureDistancesRequest>(request) ||
         std::holds_alternative<SaveRequest>(request);
}

bool Replaces(const ControlRequest& request) {
  return std::holds_alternative<LoadSceneRequest>(request) ||
         std::holds_alternative<LoadMeshRequest>(request);
}

/// Returns whether all three numbers are plausible as metres, newtons or rates.
template <typename Three>
bool AllSound(const Three& v) {
  return std::all_of(v.begin(), v.end(), [](double x) {
    return std::isfinite(x) && std::abs(x) < 1e3;
  });
}

}  // namespace

ControlServer::ControlServer(ControlledPeer& peer, bool device_hand)
    : peer_(&peer), device_hand_(device_hand), task_(peer) {}

ControlServer::Host* ControlServer::HostOf(HostId id, std::int64_t now_ns) {
  if (id == 0) return nullptr;
  const auto known = hosts_.find(id);
  if (known == hosts_.end() && hosts_.size() >= kMostHosts) return nullptr;
  Host& host = hosts_[id];
  host.heard_ns = now_ns;
  return &host;
}

void ControlServer::Reply(HostId host, std::uint64_t number, const Answer& answer) {
  answers_.push_back({host, number, answer});
}

void ControlServer::OnScene(std::optional<ControlScene> scene, std::int64_t now_ns) {
  task_.End({false, "another scene has taken the place of the one in hand"});
  AnswerTasks();
  if (scene_) old_scene_ = *scene_;
  scene_ = std::move(scene);
  facts_ = {};
  facts_.time_ns = now_ns;
  distance_held_ = -1;
}

void ControlServer::OnRequest(HostId id, const std::string& host_name, std::uint64_t number,
                              const ControlRequest& request, std::int64_t now_ns) {
  Host* host = HostOf(id, now_ns);
  // from any host, known or not
  if (std::holds_alternative<EmergencyStopRequest>(request)) Stop();
  if (host == nullptr) {
    if (stopped_ && std::holds_alternative<EmergencyStopRequest>(request)) {
      return Reply(id, number, {true, ""});
    }
    return Refuse(
        id, number,
        "the controller has " + std::to_string(kMostHosts) + " hosts, the most there are");
  }
  host->name = host_name;
  if (number <= host->last_number) return;
  host->last_number = number;
  if (const auto* rate = std::get_if<SnapshotRateRequest>(&request)) {
    const bool can_be = rate->rate_hz >= 1 && rate->rate_hz <= kMostRate;
    if (can_be) host->rate_hz = rate->rate_hz;
    return Reply(id, number,
                 can_be ? Answer{true, ""} : Answer{false, "rate: expected 1 to 1000 a second"});
  }
  if (const std::optional<Answer> answer = Do(id, number, request, now_ns)) {
    Reply(id, number, *answer);
  }
}

std::optional<Answer> ControlServer::Do(HostId host, std::uint64_t number,
                                        const ControlRequest& request, std::int64_t now_ns) {
  if (std::holds_alternative<QuitRequest>(request)) {
    peer_->Quit();
    return Answer{true, ""};
  }
  if (std::holds_alternative<EmergencyStopRequest>(request)) return Answer{true, ""};
  if (std::holds_alternative<ResumeRequest>(request)) {
    Resume();
    return Answer{true, ""};
  }
  if (!scene_) return Answer{false, "the scene is being loaded"};
  if (IsSlow(request)) {
    if (jobs_.size() >= kMostWaiting) return Answer{false, "too many requests wait already"};
    if (Replaces(request)) {
      const std::string why = WhyNotHand(host, false);
      if (!why.empty()) return Answer{false, why};
    }
    jobs_[next_job_] = {host, number};
    peer_->Begin(next_job_++, request);
    return std::nullopt;
  }
  if (const auto* parameter = std::get_if<SetParameterRequest>(&request)) {
    const Answer set = Do(*parameter);
    if (set.ok && parameter->name == "device_clutch") {
      clutch_host_ = parameter->value >= 0.5 ? host : 0;
    }
    return set;
  }
  if (const auto* clearance = std::get_if<SetClearanceRequest>(&request)) return Do(*clearance);
  if (const auto* view = std::get_if<SetViewRequest>(&request)) return Do(*view);
  std::optional<Answer> answer;
  const std::uint64_t tag = next_tag_++;
  tasks_[tag] = {host, number};
  task_.Next(tag);
  if (const auto* grab = std::get_if<GrabRequest>(&request)) answer = Do(host, *grab, now_ns);
  if (const auto* ask = std::get_if<AskForRequest>(&request)) answer = Do(host, *ask, now_ns);
  if (const auto* give = std::get_if<GiveRequest>(&request)) answer = Do(host, *give, now_ns);
  if (const auto* back = std::get_if<RetraceRequest>(&request)) answer = Do(host, *back, now_ns);
  if (std::holds_alternative<ReleaseRequest>(request)) {
    const std::string why = WhyNotHand(host, false);
    if (why.empty()) task_.LetGo(now_ns);
    if (!why.empty()) answer = Answer{false, why};
  }
  if (answer) {
    task_.Next(0);
    tasks_.erase(tag);
  }
  AnswerTasks();  // to the task that it replaces, too
  return answer;
}

std::string ControlServer::WhyNotHand(HostId host, bool to_take) const {
  if (stopped_ && to_take) return "emergency stop: resume first";
  const bool anothers = !device_hand_ && hand_host_ != 0 && hand_host_ != host;
  if (!anothers || (facts_.held < 0 && !task_.busy())) return {};
  const auto other = hosts_.find(hand_host_);
  return "the hand is in use by the host '" +
         (other == hosts_.end() ? std::string("?") : other->second.name) + "'";
}

Result<int> ControlServer::MovingNamed(const std::string& name) const {
  const int body = scene_->BodyNamed(name);
  if (body < 0) return Error{"the scene has no body '" + name + "'"};
  const ControlScene::Body& found = scene_->bodies[static_cast<std::size_t>(body)];
  if (found.fixed) return Error{"'" + name + "' is fixed: nobody can take it"};
  if (found.shared && scene_->own_only) {
    return Error{"'" + name + "' is shared: it is not held by other force parameters (--insist)"};
  }
  return found.moving;
}

std::optional<Answer> ControlServer::Do(HostId host, const GrabRequest& request,
                                        std::int64_t now_ns) {
  const std::string why = WhyNotHand(host, true);
  if (!why.empty()) return Answer{false, why};
  const Result<int> moving = MovingNamed(request.body);
  if (!moving) return Answer{false, moving.error().what};
  if (request.grasp_W && !AllSound(*request.grasp_W)) {
    return Answer{false, "the grasped point is no place"};
  }
  if (device_hand_ && request.grasp_W && facts_.held < 0) {
    // the device leads the part from the point that the host pointed at
    peer_->ChangeWorkspace({.p_WD = AsVec3(*request.grasp_W)});
  }
  task_.Take(*moving, request, *scene_, now_ns);
  TakeHand(host);
  return std::nullopt;
}

std::optional<Answer> ControlServer::Do(HostId host, const AskForRequest& request,
                                        std::int64_t now_ns) {
  const std::string why = WhyNotHand(host, true);
  if (!why.empty()) return Answer{false, why};
  const Result<int> moving = MovingNamed(request.body);
  if (!moving) return Answer{false, moving.error().what};
  const auto body = static_cast<std::size_t>(scene_->BodyNamed(request.body));
  if (scene_->bodies[body].shared) {
    return Answer{false, "'" + request.body + "' is shared: several may grab it"};
  }
  const SimulationFacts::Body& fact = facts_.bodies[static_cast<std::size_t>(*moving)];
  if (fact.holder_count == 0) return Answer{false, "nobody holds '" + request.body + "': grab it"};
  if (facts_.held == *moving) return Answer{false, "'" + request.body + "' is in your hand"};
  task_.AskFor(*moving, *scene_, now_ns);
  TakeHand(host);
  return std::nullopt;
}

std::optional<Answer> ControlServer::Do(HostId host, const GiveRequest& request,
                                        std::int64_t now_ns) {
  const std::string why = WhyNotHand(host, false);
  if (!why.empty()) return Answer{false, why};
  if (facts_.held < 0) return Answer{false, "the hand is empty"};
  for (const SnapshotPeer& peer : peers_) {
    char id[17];
    std::snprintf(id, sizeof id, "%016llx", static_cast<unsigned long long>(peer.id));
    if (!peer.here || !peer.active || !peer.refused.empty()) continue;
    if (peer.name != request.peer && id != request.peer) continue;
    task_.Give(peer.id, now_ns);
    return std::nullopt;
  }
  return Answer{false, "nobody here who takes part is called '" + request.peer + "'"};
}

std::optional<Answer> ControlServer::Do(HostId host, const RetraceRequest& request,
                                        std::int64_t now_ns) {
  const std::string why = WhyNotHand(host, true);
  if (!why.empty()) return Answer{false, why};
  if (device_hand_) return Answer{false, "a device moves the hand: bring the part back with it"};
  task_.GoBack(request.to, now_ns);
  TakeHand(host);
  return std::nullopt;
}

Answer ControlServer::Do(const SetParameterRequest& request) {
  struct Range {
    const char* name;
    double GoalLimits::*value;
    double least;
    double most;
  };
  struct DeviceRange {
    const char* name;
    double least;
    double most;
  };
  const auto out_of = [](const auto& range, double value) -> std::string {
    if (value >= range.least && value <= range.most) return {};
    char text[120];
    std::snprintf(text, sizeof text, "%s: expected a number from %g to %g", range.name, range.least,
                  range.most);
    return text;
  };
  static constexpr std::array kRanges{
      Range{"hand_force_N", &GoalLimits::force, 0.1, GoalLimits::kMostForce},
      Range{"hand_speed_m_s", &GoalLimits::speed, 0.01, GoalLimits::kMostSpeed},
      Range{"hand_smoothing_s", &GoalLimits::smoothing, 0.0, 0.2}};
  static constexpr std::array kDeviceRanges{
      DeviceRange{"device_scale", Workspace::kLeastScale, Workspace::kMostScale},
      DeviceRange{"device_recentre", 0, Workspace::kMostRecentre},
      DeviceRange{"device_clutch", 0, 1}};
  std::string names;
  for (const Range& range : kRanges) {
    names += range.name + std::string(", ");
    if (request.name != range.name) continue;
    const std::string fault = out_of(range, request.value);
    if (!fault.empty()) return {false, fault};
    task_.limits().*range.value = request.value;
    task_.TellLimits();
    return {true, ""};
  }
  for (const DeviceRange& range : kDeviceRanges) {
    names += range.name + std::string(&range == &kDeviceRanges.back() ? "" : ", ");
    if (request.name != range.name) continue;
    const std::string fault = out_of(range, request.value);
    if (!fault.empty()) return {false, fault};
    WorkspaceChange change;
    if (request.name == "device_scale") return Rescale(request.value);
    if (request.name == "device_recentre") change.recentre = request.value;
    if (request.name == "device_clutch") change.clutch = request.value >= 0.5;
    return ChangeWorkspace(change);
  }
  return {false, "there is no parameter '" + request.name + "': there are " + names};
}

Answer ControlServer::Do(const SetViewRequest& request) {
  const auto& q = request.q_WV;
  const Quat q_WV(q[3], q[0], q[1], q[2]);
  if (!(std::abs(q_WV.norm() - 1) < 1e-3)) return {false, "the view is no rotation"};
  return ChangeWorkspace({.q_WV = q_WV.normalized()});
}

Answer ControlServer::Rescale(double scale) {
  const Answer there = ChangeWorkspace({});
  if (!there.ok) return there;
  const bool said = peer_->Order({.kind = Command::Kind::kScale, .metres = scale});
  return said ? there : Answer{false, "too many orders at once: ask again"};
}

Answer ControlServer::ChangeWorkspace(const WorkspaceChange& change) {
  if (device_hand_ && peer_->ChangeWorkspace(change)) return {true, ""};
  return {false, "no device at the controller moves the hand"};
}

Answer ControlServer::Do(const SetClearanceRequest& request) {
  const ClearanceBounds& bounds = scene_->clearance;
  char text[160];
  if (request.force_layer != -1 &&
      (request.force_layer < bounds.least_layer || request.force_layer > bounds.most_layer)) {
    std::snprintf(text, sizeof text, "force layer: expected a whole number from %d to %d",
                  bounds.least_layer, bounds.most_layer);
    return {false, text};
  }
  if (!bounds.Allows(request.displacement_m)) {
    std::snprintf(text, sizeof text, "displacement: expected from %g to %g m", -bounds.most_outward,
                  bounds.most_inward);
    return {false, text};
  }
  const bool said =
      peer_->Order({.kind = Command::Kind::kLayer, .layer = request.force_layer}) &&
      peer_->Order({.kind = Command::Kind::kDisplace, .metres = request.displacement_m});
  return said ? Answer{true, ""} : Answer{false, "too many orders at once: ask again"};
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
  if (!turns || !AllSound(goal.X_WG.p) || !AllSound(goal.linear) || !AllSound(goal.angular)) return;
  const auto input = goal.kind == HostGoal::Kind::kPose   ? GoalOrder::Input::kPose
                     : goal.kind == HostGoal::Kind::kRate ? GoalOrder::Input::kRate
                                                          : GoalOrder::Input::kPush;
  const Pose X_WG{goal.X_WG.q.normalized(), goal.X_WG.p};
  task_.Mean(input, X_WG, goal.linear, goal.angular);
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

void ControlServer::OnNews(const HoldingNews& news, const std::string& line) {
  if (scene_) task_.OnNews(news, line, *scene_);
  AnswerTasks();
  OnLine(line);
}

void ControlServer::OnLine(const std::string& line) {
  news_ = line;
  ++news_count_;
}

void ControlServer::Stop() {
  task_.End({false, "emergency stop"});
  AnswerTasks();
  if (!std::exchange(stopped_, true)) {
    OnLine("emergency stop: the hand lets go, and takes nothing until it is resumed");
  }
  peer_->StopDevice(true);
  LetGo();
}

void ControlServer::LetGo() {
  lets_go_ = facts_.held >= 0 || facts_.wanted >= 0;
  peer_->Order({.kind = Command::Kind::kRelease});
}

void ControlServer::Resume() {
  if (std::exchange(stopped_, false)) OnLine("the hand may take parts again");
  peer_->StopDevice(false);
}

void ControlServer::OnDone(std::uint64_t job, const Answer& answer) {
  const auto asked = jobs_.find(job);
  if (asked == jobs_.end()) return;
  Reply(asked->second.host, asked->second.number, answer);
  jobs_.erase(asked);
}

void ControlServer::AnswerTasks() {
  while (const std::optional<HandTask::Ended> ended = task_.TakeEnded()) {
    const auto asked = tasks_.find(ended->tag);
    if (asked == tasks_.end()) continue;
    Reply(asked->second.host, asked->second.number, *ended);
    tasks_.erase(asked);
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
    if (now_ns - host.heard_ns > kLostNs) lost.push_back(id);
  }
  for (const HostId id : lost) Lose(id, "is gone", now_ns);
  const auto hand = hosts_.find(hand_host_);
  if (hand == hosts_.end() || held_still_ || device_hand_) return;
  if (now_ns - hand->second.heard_ns <= kQuietNs || !facts_.attached || task_.going_back()) return;
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
