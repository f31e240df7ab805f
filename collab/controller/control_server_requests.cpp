#include <algorithm>
#include <cmath>
#include <cstdio>

#include "collab/controller/control_server.h"
#include "collab/controller/plain.h"
#include "engine/base/files/regular_file.h"

// Does the hosts' requests, or says why not; control_server.cpp handles goals, facts and the loss
// of hosts.

namespace tandem {

namespace {

bool IsSlow(const ControlRequest& request) {
  return std::holds_alternative<LoadSceneRequest>(request) ||
         std::holds_alternative<LoadMeshRequest>(request) ||
         std::holds_alternative<VoxelizeRequest>(request) ||
         std::holds_alternative<MeasureDistancesRequest>(request) ||
         std::holds_alternative<SaveRequest>(request);
}

/// Returns what a person at the controller is told of a request; empty: nothing.
std::string ToldOf(const ControlRequest& request) {
  const auto file = [](const auto& named) {
    return PlainLine(named.file);
  };
  if (const auto* save = std::get_if<SaveRequest>(&request))
    return "saves the scene: " + file(*save);
  if (const auto* load = std::get_if<LoadSceneRequest>(&request)) return "loads " + file(*load);
  if (const auto* mesh = std::get_if<LoadMeshRequest>(&request)) return "adds " + file(*mesh);
  if (std::holds_alternative<ResumeRequest>(request)) return "ends the emergency stop";
  if (std::holds_alternative<QuitRequest>(request)) return "ends the controller";
  return {};
}

bool Replaces(const ControlRequest& request) {
  return std::holds_alternative<LoadSceneRequest>(request) ||
         std::holds_alternative<LoadMeshRequest>(request);
}

}  // namespace

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
  TellOf(*host, request, now_ns);
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

void ControlServer::TellOf(const Host& host, const ControlRequest& request, std::int64_t now_ns) {
  constexpr int kMostTold = 10;  // a second
  constexpr std::int64_t kSecondNs = 1'000'000'000;
  const std::string told = ToldOf(request);
  if (told.empty() || (std::holds_alternative<ResumeRequest>(request) && !stopped_)) return;
  if (now_ns - told_since_ns_ >= kSecondNs) {
    told_since_ns_ = now_ns;
    told_ = 0;
  }
  if (++told_ > kMostTold) return;
  lines_.push_back("the host '" + (host.name.empty() ? std::string("?") : host.name) + "' " + told +
                   (told_ == kMostTold ? " (no more such lines for a second)" : ""));
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
    if (jobs_.size() >= kMostWaiting)
      return Answer{false, "too many requests are waiting: wait for their answers"};
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
    return Error{"'" + name +
                 "' is shared: a peer with force parameters of its own cannot hold it"};
  }
  return found.moving;
}

std::optional<Answer> ControlServer::Do(HostId host, const GrabRequest& request,
                                        std::int64_t now_ns) {
  const std::string why = WhyNotHand(host, true);
  if (!why.empty()) return Answer{false, why};
  const Result<int> moving = MovingNamed(request.body);
  if (!moving) return Answer{false, moving.error().what};
  if (request.grasp_W && !AllFinite(*request.grasp_W)) {
    return Answer{false, "the grasped point is not a place in space"};
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
  return Answer{false, "no active peer here is called '" + request.peer + "'"};
}

std::optional<Answer> ControlServer::Do(HostId host, const RetraceRequest& request,
                                        std::int64_t now_ns) {
  const std::string why = WhyNotHand(host, true);
  if (!why.empty()) return Answer{false, why};
  if (device_hand_)
    return Answer{false, "a device moves the hand: move the body back with the device"};
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
  if (!(std::abs(q_WV.norm() - 1) < 1e-3))
    return {false, "the view's orientation is not a rotation"};
  return ChangeWorkspace({.q_WV = q_WV.normalized()});
}

Answer ControlServer::Rescale(double scale) {
  const Answer there = ChangeWorkspace({});
  if (!there.ok) return there;
  const bool queued = peer_->Order({.kind = Command::Kind::kScale, .metres = scale});
  return queued ? there : Answer{false, "too many commands at once: ask again"};
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
  const bool queued =
      peer_->Order({.kind = Command::Kind::kLayer, .layer = request.force_layer}) &&
      peer_->Order({.kind = Command::Kind::kDisplace, .metres = request.displacement_m});
  return queued ? Answer{true, ""} : Answer{false, "too many commands at once: ask again"};
}

}  // namespace tandem
