#include "collab/controller/controller.h"

#include <array>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <thread>
#include <utility>
#include <vector>

#include <pthread.h>

#include "collab/controller/control_server.h"
#include "collab/controller/plain.h"
#include "collab/dds/control_domain.h"
#include "collab/dds/control_wire.h"
#include "collab/dds/fast_reader.h"

// The host's end of the command interface. It has two threads: the host's, and one of ours that
// receives and shows that the process lives.

namespace tandem {

namespace {

constexpr std::int64_t kBeatNs = 50'000'000;
constexpr std::chrono::milliseconds kKeysStep{10};  // between two searches for keys
constexpr std::int64_t kGoneNs = 500'000'000;       // time without a snapshot
constexpr std::int64_t kLeastGoalNs = 1'000'000;  // between two goals
constexpr std::size_t kMostWaiting = 32;          // requests without an answer, so that none is lost

}  // namespace

class Controller::Link {
 public:
  Link(std::string name, const Options& options, ControlDomain domain)
      : name_(std::move(name)), host_name_(options.host), domain_(std::move(domain)) {
    std::random_device random;
    while (id_ == 0) id_ = std::uint64_t{random()} << 32U | random();
  }
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  bool Open();
  /// Waits for at most a tenth of a second until the controller has been heard.
  bool Meet();
  /// Returns a request with the next number and this host's name, to be filled in.
  tandem_control_Request NextRequest();
  /// Repeats a first request, by which the controller knows this host's name, until it is answered
  /// or that time has come. While a controller is flooded it may drop the samples of an unknown
  /// host.
  void Introduce(std::int64_t until_ns);
  /// Returns what is wrong with the version of the controller that was heard.
  std::optional<Error> VersionFault() const;

  bool attached() const {
    const std::lock_guard lock(mutex_);
    return Heard();
  }
  void Send(const ControlRequest& request, OnAnswer on_answer);
  void Mean(HostGoal::Kind kind, const Pose& X_WG, const Vec3& linear, const Vec3& angular);
  void OnSnapshot(std::function<void(const ControllerSnapshot&)> callback) {
    on_snapshot_ = std::move(callback);
  }
  const ControllerSnapshot& snapshot() const { return snapshot_; }
  bool Poll();
  void WaitForSomething(std::chrono::milliseconds at_most) {
    std::unique_lock lock(mutex_);
    something_.wait_for(lock, at_most, [this] {
      return Fresh();
    });
  }

 private:
  /// A copy of a sample that owns its lists, in the form that FromWire reads.
  struct SceneCopy {
    tandem_control_Scene wire{};
    std::vector<tandem_control_SceneBody> bodies;

    void Keep(const tandem_control_Scene& sample) {
      wire = sample;
      bodies.assign(sample.bodies._buffer, sample.bodies._buffer + sample.bodies._length);
      wire.bodies._buffer = bodies.data();
    }
  };
  bool Fresh() const { return fresh_ || !answers_.empty(); }
  bool Heard() const { return heard_ns_ != 0 && MonotonicNow_ns() - heard_ns_ < kGoneNs; }
  void Run();
  void Receive();
  void Beat(bool goodbye);
  void AnswerForTheGone();

  const std::string name_;
  const std::string host_name_;
  ControlDomain domain_;
  std::uint64_t id_ = 0;
  dds_entity_t requests_ = 0;
  dds_entity_t goals_ = 0;
  dds_entity_t answers_reader_ = 0;
  dds_entity_t scenes_ = 0;
  dds_entity_t snapshots_ = 0;
  dds_entity_t wake_ = 0;
  dds_entity_t waitset_ = 0;

  // used by the host's thread
  std::uint64_t next_number_ = 1;
  std::map<std::uint64_t, OnAnswer> waiting_;  // callbacks of unanswered requests, by number
  std::function<void(const ControllerSnapshot&)> on_snapshot_;
  ControllerSnapshot snapshot_;
  std::int64_t gone_since_ns_ = 0;

  // used by both threads
  mutable std::mutex mutex_;
  std::condition_variable something_;
  bool stopping_ = false;
  HostGoal goal_;            // newest goal
  bool goal_waits_ = false;  // it is to be sent as soon as there is time
  std::int64_t last_goal_ns_ = 0;
  std::uint64_t controller_ = 0;  // id of the controller that was heard
  bool replaced_ = false;         // another controller has taken its name
  double rate_hz_ = 60;           // rate of snapshots that this host has asked for
  std::int64_t next_snapshot_ns_ = 0;
  SceneCopy scene_;
  std::uint32_t other_version_ = 0;
  bool fresh_ = false;
  ControllerSnapshot newest_;
  std::deque<HostAnswer> answers_;
  std::int64_t heard_ns_ = 0;

  std::thread thread_;
};

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
  const auto take = [](dds_entity_t reader, auto use) {
    std::array<void*, 16> samples{};
    std::array<dds_sample_info_t, 16> infos{};
    dds_return_t taken = 0;
    while ((taken = dds_take(reader, samples.data(), infos.data(), 16, 16)) > 0) {
      for (int i = 0; i < taken; ++i) {
        const auto k = static_cast<std::size_t>(i);
        if (infos[k].valid_data) use(samples[k]);
      }
      dds_return_loan(reader, samples.data(), taken);
    }
  };
  bool heard = false;
  const std::lock_guard lock(mutex_);
  take(scenes_, [&](const void* sample) {
    const auto& scene = *static_cast<const tandem_control_Scene*>(sample);
    other_version_ = scene.version == kControlVersion ? 0 : scene.version;
    replaced_ = replaced_ || (controller_ != 0 && controller_ != scene.controller);
    controller_ = scene.controller;
    if (other_version_ == 0) scene_.Keep(scene);
  });
  take(snapshots_, [&](const void* sample) {
    heard_ns_ = MonotonicNow_ns();
    const auto& wire = *static_cast<const tandem_control_Snapshot*>(sample);
    // they come at the highest rate that any host has asked for
    if (heard_ns_ < next_snapshot_ns_ && wire.scene_number == newest_.scene_number) return;
    const auto period_ns = static_cast<std::int64_t>(1e9 / rate_hz_);
    next_snapshot_ns_ = std::max(next_snapshot_ns_ + period_ns, heard_ns_ - period_ns / 2);
    if (!FromWire(wire, scene_.wire, newest_)) return;
    fresh_ = heard = true;
  });
  take(answers_reader_, [&](const void* sample) {
    const auto& wire = *static_cast<const tandem_control_Answer*>(sample);
    if (wire.host != id_) return;
    answers_.push_back(FromWire(wire));
    heard = true;
  });
  if (heard) something_.notify_all();
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
  answers_.push_back(
      {id_,
       wire.number,
       {false, !whole  ? "a name is too long"
               : !room ? "too many requests wait for an answer already"
                       : "the request could not be sent"}});
}

void Controller::Link::Mean(HostGoal::Kind kind, const Pose& X_WG, const Vec3& linear,
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
    if (Heard()) gone_since_ns_ = 0;
    else if (gone_since_ns_ == 0) gone_since_ns_ = now_ns;
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

namespace {

/// The keys that a controller of that name has made for its hosts, and a line that identifies them.
struct HostKeys {
  std::filesystem::path folder;  // empty: it has made none
  std::string which;

  friend bool operator==(const HostKeys&, const HostKeys&) = default;
};

HostKeys FindHostKeys(const std::filesystem::path& folder) {
  std::ifstream member(folder / "member.txt");  // written last
  HostKeys keys{.folder = folder, .which = {}};
  if (!std::getline(member, keys.which)) return {};
  return keys;
}

}  // namespace

Result<Controller> Controller::Attach(const std::string& name, const Options& options) {
  std::filesystem::path folder = options.keys;
  if (folder.empty()) {
    const Result<std::filesystem::path> own = ControlFolder();
    if (!own) return own.error();
    folder = *own / (name + ".keys") / "host";
  }
  const std::int64_t until_ns =
      MonotonicNow_ns() + static_cast<std::int64_t>(1e9 * options.timeout_s);
  for (;;) {
    const HostKeys keys = FindHostKeys(folder);
    // without keys any user of the machine may speak under that name
    if (options.secured && keys.folder.empty()) {
      if (MonotonicNow_ns() > until_ns) {
        return Error{"no controller '" + name + "' with keys on this machine: 'tandem peer " +
                     "--control " + name + " --secure KEYS …' starts one"};
      }
      std::this_thread::sleep_for(kKeysStep);
      continue;
    }
    Result<ControlDomain> domain = EnterControlDomain(name, options.domain, keys.folder);
    if (!domain) return domain.error();
    auto link = std::make_unique<Link>(name, options, *std::move(domain));
    if (!link->Open()) return Error{"the command interface cannot be opened on this machine"};
    // a controller that is only starting has its keys later
    do {
      if (link->Meet()) {
        link->Introduce(until_ns);
        return Controller(std::move(link));
      }
      if (std::optional<Error> fault = link->VersionFault()) return *fault;
      if (MonotonicNow_ns() > until_ns) {
        return Error{"no controller '" + name + "' on this machine: 'tandem peer --control " +
                     name + " …' starts one"};
      }
    } while (FindHostKeys(folder) == keys);
  }
}

Controller::Controller(std::unique_ptr<Link> link) : link_(std::move(link)) {}
Controller::Controller(Controller&&) noexcept = default;
Controller& Controller::operator=(Controller&&) noexcept = default;
Controller::~Controller() = default;

bool Controller::attached() const {
  return link_->attached();
}

void Controller::Send(const ControlRequest& request, OnAnswer on_answer) {
  link_->Send(request, std::move(on_answer));
}

Answer Controller::Ask(const ControlRequest& request, double timeout_s) {
  // the callback keeps it alive: an answer may come after the time is up
  const auto answered = std::make_shared<std::optional<Answer>>();
  link_->Send(request, [answered](const Answer& answer) {
    *answered = answer;
  });
  const std::int64_t until_ns = MonotonicNow_ns() + static_cast<std::int64_t>(1e9 * timeout_s);
  while (!*answered && MonotonicNow_ns() < until_ns) Wait(std::chrono::milliseconds(20));
  return answered->value_or(Answer{false, "no answer in time"});
}

void Controller::SetGoal(const PlainPose& X_WG) {
  link_->Mean(HostGoal::Kind::kPose, AsPose(X_WG), Vec3::Zero(), Vec3::Zero());
}

void Controller::SetRate(const std::array<double, 3>& v_W, const std::array<double, 3>& w_W) {
  link_->Mean(HostGoal::Kind::kRate, Pose(), AsVec3(v_W), AsVec3(w_W));
}

void Controller::SetPush(const std::array<double, 3>& force_N,
                         const std::array<double, 3>& torque_Nm) {
  link_->Mean(HostGoal::Kind::kPush, Pose(), AsVec3(force_N), AsVec3(torque_Nm));
}

void Controller::OnSnapshot(std::function<void(const ControllerSnapshot&)> callback) {
  link_->OnSnapshot(std::move(callback));
}

const ControllerSnapshot& Controller::snapshot() const {
  return link_->snapshot();
}

bool Controller::Poll() {
  return link_->Poll();
}

bool Controller::Wait(std::chrono::milliseconds at_most) {
  if (link_->Poll()) return true;
  link_->WaitForSomething(at_most);
  return link_->Poll();
}

}  // namespace tandem
