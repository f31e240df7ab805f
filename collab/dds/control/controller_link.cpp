#include "collab/dds/control/controller_link.h"

#include <algorithm>
#include <array>
#include <random>

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "collab/dds/control/control_folder.h"
#include "collab/dds/control/control_packet.h"

namespace tandem {

namespace {

constexpr std::int64_t kBeatNs = 50'000'000;
constexpr std::int64_t kLeastGoalNs = 1'000'000;  // between two goals
constexpr std::int64_t kTryNs = 10'000'000;       // from one try to connect to the next
constexpr std::size_t kMostWaiting = 32;  // requests without an answer, so that none is lost
constexpr int kMostPacketsATurn = 256;
constexpr int kTriesToSend = 20;  // tries, 5 ms apart

}  // namespace

Controller::Link::Link(std::string name, const Options& options, std::filesystem::path folder)
    : name_(std::move(name)),
      host_name_(options.host),
      folder_(std::move(folder)),
      wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  std::random_device random;
  while (id_ == 0) id_ = std::uint64_t{random()} << 32U | random();
  thread_ = std::thread([this] {
    Run();
  });
}

Controller::Link::~Link() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  Wake();
  thread_.join();
  Beat(true);
}

bool Controller::Link::Meet() {
  std::unique_lock lock(mutex_);
  return something_.wait_for(lock, std::chrono::milliseconds(100), [this] {
    return fresh_;
  });
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
  for (std::int64_t now_ns = MonotonicNowNs(); waiting_.contains(wire.number) && now_ns < until_ns;
       now_ns = MonotonicNowNs()) {
    if (now_ns >= next_ns) {
      Send(PacketOf(wire));
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
  Send(PacketOf(wire));
}

ControlConnection::Outcome Controller::Link::Send(const std::vector<char>& packet) {
  const std::lock_guard lock(mutex_);
  return connection_ ? connection_->Send(packet) : Outcome::kGone;
}

bool Controller::Link::Deliver(const tandem_control_Request& wire) {
  const std::vector<char> packet = PacketOf(wire);
  for (int tries = 0; tries < kTriesToSend; ++tries) {
    Outcome outcome = Outcome::kGone;
    {
      const std::lock_guard lock(mutex_);
      if (connection_) outcome = connection_->Send(packet);
      if (outcome == Outcome::kDone) last_sent_ = wire.number;
    }
    if (outcome == Outcome::kDone) return true;
    if (outcome == Outcome::kUnusable) return false;
    // there is no room, or the next controller of that name is about to be found
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

void Controller::Link::Wake() const {
  const std::uint64_t once = 1;
  static_cast<void>(!write(wake_.get(), &once, sizeof once));
}

void Controller::Link::WaitForInput(std::int64_t at_most_ns) const {
  std::array<pollfd, 2> waits{{{wake_.get(), POLLIN, 0}, {-1, POLLIN, 0}}};
  if (connection_) waits[1].fd = connection_->descriptor();
  const timespec time{at_most_ns / 1'000'000'000, at_most_ns % 1'000'000'000};
  ppoll(waits.data(), waits.size(), &time, nullptr);
  std::uint64_t times = 0;
  static_cast<void>(!read(wake_.get(), &times, sizeof times));
}

void Controller::Link::Connect() {
  const std::int64_t now_ns = MonotonicNowNs();
  if (connection_ || now_ns < next_try_ns_) return;
  next_try_ns_ = now_ns + kTryNs;
  const std::optional<std::string> found = FindController(folder_, name_);
  Result<ControlConnection> made = ControlConnection::To(folder_, found.value_or(name_));
  const std::lock_guard lock(mutex_);
  if (made) {
    connection_ = *std::move(made);
    why_.clear();
    // answers of the connection before do not come any more
    lost_to_ = last_sent_;
  } else {
    why_ = made.error().what;
  }
}

void Controller::Link::Run() {
  pthread_setname_np(pthread_self(), "tandem-host");
  std::int64_t next_beat_ns = 0;
  for (;;) {
    Connect();
    const std::int64_t now_ns = MonotonicNowNs();
    {
      const std::lock_guard lock(mutex_);
      if (stopping_) return;
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
    const std::int64_t until_ns = connection_ ? next_beat_ns : std::min(next_beat_ns, next_try_ns_);
    WaitForInput(std::max<std::int64_t>(until_ns - now_ns, 1));
    Receive();
  }
}

void Controller::Link::Receive() {
  bool received = false;
  const std::lock_guard lock(mutex_);
  for (int packets = 0; packets < kMostPacketsATurn && connection_; ++packets) {
    const Outcome outcome = connection_->Receive(packet_);
    if (outcome == Outcome::kLater) break;
    if (outcome == Outcome::kGone) connection_.reset();
    if (outcome == Outcome::kDone && Take(packet_)) received = true;
  }
  if (received) something_.notify_all();
}

bool Controller::Link::Take(std::span<char> packet) {
  bool received = false;
  const std::optional<ControlTopic> topic = TopicOf(packet);
  if (topic == ControlTopic::kScene) {
    UsePacket<tandem_control_Scene>(packet, *topic, [&](const tandem_control_Scene& scene) {
      other_version_ = scene.version == kControlVersion ? 0 : scene.version;
      controller_ = scene.controller;
      if (other_version_ == 0) scene_.Keep(scene);
    });
  }
  if (topic == ControlTopic::kSnapshot) {
    UsePacket<tandem_control_Snapshot>(packet, *topic, [&](const tandem_control_Snapshot& wire) {
      received = Take(wire);
    });
  }
  if (topic == ControlTopic::kAnswer) {
    UsePacket<tandem_control_Answer>(packet, *topic, [&](const tandem_control_Answer& wire) {
      if (wire.host != id_) return;
      answers_.push_back(FromWire(wire));
      received = true;
    });
  }
  return received;
}

bool Controller::Link::Take(const tandem_control_Snapshot& wire) {
  received_ns_ = MonotonicNowNs();
  // they come at the highest rate that any host has asked for
  if (received_ns_ < next_snapshot_ns_ && wire.scene_number == newest_.scene_number) return false;
  const auto period_ns = static_cast<std::int64_t>(1e9 / rate_hz_);
  next_snapshot_ns_ = std::max(next_snapshot_ns_ + period_ns, received_ns_ - period_ns / 2);
  if (!FromWire(wire, scene_.wire, newest_)) return false;
  fresh_ = true;
  return true;
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
  if (whole && room && Deliver(wire)) {
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
    const std::int64_t now_ns = MonotonicNowNs();
    if (now_ns - last_goal_ns_ < kLeastGoalNs) {
      if (!std::exchange(goal_waits_, true)) Wake();
      return;
    }
    goal_waits_ = false;
    last_goal_ns_ = now_ns;
    ToWire(goal_, wire);
  }
  wire.host = id_;
  Send(PacketOf(wire));
}

void Controller::Link::AnswerForTheGone() {
  // a controller that is busy for long still sends snapshots
  const std::int64_t now_ns = MonotonicNowNs();
  std::uint64_t lost_to = 0;
  {
    const std::lock_guard lock(mutex_);
    lost_to = lost_to_;
    if (Heard())
      gone_since_ns_ = 0;
    else if (gone_since_ns_ == 0)
      gone_since_ns_ = now_ns;
  }
  const bool is_gone = gone_since_ns_ != 0 && now_ns - gone_since_ns_ >= kGoneNs;
  const auto end = is_gone ? waiting_.end() : waiting_.upper_bound(lost_to);
  std::vector<OnAnswer> orphans;
  for (auto waiting = waiting_.begin(); waiting != end; ++waiting) {
    orphans.push_back(std::move(waiting->second));
  }
  waiting_.erase(waiting_.begin(), end);
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
