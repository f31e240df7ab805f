#include "collab/dds/control/controller_link.h"

#include <algorithm>

#include <pthread.h>

#include "collab/dds/cyclone/take_samples.h"

namespace tandem {

namespace {

constexpr std::int64_t kBeatNs = 50'000'000;
constexpr std::int64_t kLeastGoalNs = 1'000'000;  // between two goals
constexpr std::size_t kMostWaiting = 32;  // requests without an answer, so that none is lost

}  // namespace

bool Controller::Link::Open() {
  const dds_entity_t participant = domain_.participant.get();
  requests_ = ControlWriter(participant, ControlTopic::kRequest);
  goals_ = ControlWriter(participant, ControlTopic::kGoal);
  const auto ignore = [](dds_instance_handle_t, Drop) {};
  answers_reader_ = ControlReader(participant, ControlTopic::kAnswer, ignore);
  scenes_ = ControlReader(participant, ControlTopic::kScene, ignore);
  snapshots_ = ControlReader(participant, ControlTopic::kSnapshot, ignore);
  wake_ = dds_create_guardcondition(participant);
  waitset_ = dds_create_waitset(participant);
  for (const dds_entity_t entity : {requests_, goals_, answers_reader_, scenes_, snapshots_}) {
    if (entity < 0) return false;
  }
  for (const dds_entity_t reader : {answers_reader_, scenes_, snapshots_}) {
    dds_waitset_attach(waitset_, dds_create_readcondition(reader, DDS_ANY_STATE), 0);
  }
  dds_waitset_attach(waitset_, wake_, 0);
  thread_ = std::thread([this] {
    Run();
  });
  return true;
}

Controller::Link::~Link() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  if (thread_.joinable()) {
    dds_set_guardcondition(wake_, true);
    thread_.join();
    // a goodbye is the last goal and best effort, so it is sent three times
    for (int times = 0; times < 3; ++times) Beat(true);
  }
  domain_.participant.Delete();
  domain_.domain.Delete();
}

bool Controller::Link::Meet() {
  for (int looks = 0; looks < 20; ++looks) {
    dds_publication_matched_status_t requests{};
    dds_publication_matched_status_t goals{};
    dds_get_publication_matched_status(requests_, &requests);
    dds_get_publication_matched_status(goals_, &goals);
    const bool matched = requests.current_count > 0 && goals.current_count > 0;
    std::unique_lock lock(mutex_);
    if (matched && fresh_) return true;
    something_.wait_for(lock, std::chrono::milliseconds(5));
  }
  return false;
}

tandem_control_Request Controller::Link::NextRequest() {
  tandem_control_Request wire{};
  wire.host = id_;
  wire.number = next_number_++;
  if (host_name_.size() < sizeof wire.host_name) host_name_.copy(wire.host_name, host_name_.size());
  return wire;
}

void Controller::Link::Introduce(std::int64_t until_ns) {
  constexpr std::int64_t kAgainNs = 250'000'000;
  tandem_control_Request wire = NextRequest();
  ToWire(SnapshotRateRequest{}, wire);
  waiting_[wire.number] = {};
  std::int64_t next_ns = 0;
  for (std::int64_t now_ns = MonotonicNow_ns(); waiting_.contains(wire.number) && now_ns < until_ns;
       now_ns = MonotonicNow_ns()) {
    if (now_ns >= next_ns) {
      dds_write(requests_, &wire);
      next_ns = now_ns + kAgainNs;
    }
    WaitForSomething(std::chrono::milliseconds(20));
    Poll();
  }
}

std::optional<Error> Controller::Link::VersionFault() const {
  const std::lock_guard lock(mutex_);
  if (other_version_ == 0) return std::nullopt;
  return Error{"the controller '" + name_ + "' speaks version " + std::to_string(other_version_) +
               " of the command interface, this program " + std::to_string(kControlVersion)};
}

void Controller::Link::Beat(bool goodbye) {
  tandem_control_Goal wire{};
  HostGoal goal;
  {
    const std::lock_guard lock(mutex_);
    goal = goal_;
  }
  // goals are repeated because one may be lost; a goal that was heard already does not count again
  if (goodbye) goal.kind = HostGoal::Kind::kGoodbye;
  ToWire(goal, wire);
  wire.host = id_;
  dds_write(goals_, &wire);
}

void Controller::Link::Run() {
  pthread_setname_np(pthread_self(), "tandem-host");
  std::int64_t next_beat_ns = 0;
  for (;;) {
    const std::int64_t now_ns = MonotonicNow_ns();
    {
      const std::lock_guard lock(mutex_);
      if (goal_waits_) next_beat_ns = std::min(next_beat_ns, last_goal_ns_ + kLeastGoalNs);
      if (now_ns >= next_beat_ns && goal_waits_) {
        goal_waits_ = false;
        last_goal_ns_ = now_ns;
      }
    }
    if (now_ns >= next_beat_ns) {
      Beat(false);
      next_beat_ns = now_ns + kBeatNs;
    }
    dds_waitset_wait(waitset_, nullptr, 0, std::max<std::int64_t>(next_beat_ns - now_ns, 1));
    {
      const std::lock_guard lock(mutex_);
      if (stopping_) return;
    }
    bool woken = false;
    dds_take_guardcondition(wake_, &woken);
    Receive();
  }
}

void Controller::Link::Receive() {
  bool received = false;
  const std::lock_guard lock(mutex_);
  TakeData<tandem_control_Scene>(scenes_, [&](const tandem_control_Scene& scene) {
    other_version_ = scene.version == kControlVersion ? 0 : scene.version;
    replaced_ = replaced_ || (controller_ != 0 && controller_ != scene.controller);
    controller_ = scene.controller;
    if (other_version_ == 0) scene_.Keep(scene);
  });
  TakeData<tandem_control_Snapshot>(snapshots_, [&](const tandem_control_Snapshot& wire) {
    received_ns_ = MonotonicNow_ns();
    // they come at the highest rate that any host has asked for
    if (received_ns_ < next_snapshot_ns_ && wire.scene_number == newest_.scene_number) return;
    const auto period_ns = static_cast<std::int64_t>(1e9 / rate_hz_);
    next_snapshot_ns_ = std::max(next_snapshot_ns_ + period_ns, received_ns_ - period_ns / 2);
    if (!FromWire(wire, scene_.wire, newest_)) return;
    fresh_ = received = true;
  });
  TakeData<tandem_control_Answer>(answers_reader_, [&](const tandem_control_Answer& wire) {
    if (wire.host != id_) return;
    answers_.push_back(FromWire(wire));
    received = true;
  });
  if (received) something_.notify_all();
}

void Controller::Link::Send(const ControlRequest& request, OnAnswer on_answer) {
  tandem_control_Request wire = NextRequest();
  if (const auto* rate = std::get_if<SnapshotRateRequest>(&request);
      rate != nullptr && rate->rate_hz >= 1 && rate->rate_hz <= ControlServer::kMostRate) {
    const std::lock_guard lock(mutex_);
    rate_hz_ = rate->rate_hz;
    next_snapshot_ns_ = 0;
  }
  const bool whole = ToWire(request, wire);
  const bool stop = std::holds_alternative<EmergencyStopRequest>(request);
  const bool room = stop || waiting_.size() < kMostWaiting;
  if (whole && room && dds_write(requests_, &wire) == DDS_RETCODE_OK) {
    waiting_[wire.number] = std::move(on_answer);
    return;
  }
  const std::lock_guard lock(mutex_);
  waiting_[wire.number] = std::move(on_answer);
  answers_.push_back({id_,
                      wire.number,
                      {false, !whole  ? "a name is too long"
                              : !room ? "too many requests wait for an answer already"
                                      : "the request could not be sent"}});
}

void Controller::Link::SetGoal(HostGoal::Kind kind, const Pose& X_WG, const Vec3& linear,
                               const Vec3& angular) {
  tandem_control_Goal wire{};
  {
    const std::lock_guard lock(mutex_);
    goal_ = {
        .kind = kind, .seq = goal_.seq + 1, .X_WG = X_WG, .linear = linear, .angular = angular};
    // more goals than the hand takes: the newest follows when there is time for it
    const std::int64_t now_ns = MonotonicNow_ns();
    if (now_ns - last_goal_ns_ < kLeastGoalNs) {
      if (!std::exchange(goal_waits_, true)) dds_set_guardcondition(wake_, true);
      return;
    }
    goal_waits_ = false;
    last_goal_ns_ = now_ns;
    ToWire(goal_, wire);
  }
  wire.host = id_;
  dds_write(goals_, &wire);
}

void Controller::Link::AnswerForTheGone() {
  // a controller that is busy for long still sends snapshots
  const std::int64_t now_ns = MonotonicNow_ns();
  bool replaced = false;
  {
    const std::lock_guard lock(mutex_);
    replaced = std::exchange(replaced_, false);
    if (Heard())
      gone_since_ns_ = 0;
    else if (gone_since_ns_ == 0)
      gone_since_ns_ = now_ns;
  }
  if (!replaced && (gone_since_ns_ == 0 || now_ns - gone_since_ns_ < kGoneNs)) return;
  std::vector<OnAnswer> orphans;
  for (auto& [number, on_answer] : waiting_) orphans.push_back(std::move(on_answer));
  waiting_.clear();
  for (const OnAnswer& answer : orphans) {
    if (answer) answer({false, "the controller " + name_ + " is gone"});
  }
}

bool Controller::Link::Poll() {
  std::deque<HostAnswer> answers;
  bool fresh = false;
  {
    const std::lock_guard lock(mutex_);
    answers.swap(answers_);
    fresh = std::exchange(fresh_, false);
    if (fresh) std::swap(snapshot_, newest_);
  }
  if (fresh && on_snapshot_) on_snapshot_(snapshot_);
  for (const HostAnswer& answer : answers) {
    const auto waiting = waiting_.find(answer.number);
    if (waiting == waiting_.end()) continue;
    const OnAnswer call = std::move(waiting->second);
    waiting_.erase(waiting);
    if (call) call(answer.answer);
  }
  AnswerForTheGone();
  return fresh || !answers.empty();
}

}  // namespace tandem
