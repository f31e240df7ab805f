#include "collab/simulated/hands/simulated_controller.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "collab/controller/fill_facts.h"
#include "collab/simulated/hands/describe_request.h"
#include "engine/base/units.h"

namespace tandem {

namespace {

constexpr std::uint64_t kSceneHash = 1;
constexpr std::int64_t kSettleNs = 1'000'000'000;  // the value of `tandem peer`
constexpr std::int64_t kIdleNs = 50'000'000;
constexpr std::uint64_t kNewsFrames = 20;
constexpr std::uint64_t kPeersFrames = 100;

NodeOptions OptionsOf(const SimulatedController::Options& of) {
  NodeOptions options;
  options.peer.id = of.id;
  options.peer.settle_ns = kSettleNs;
  options.name = of.name;
  options.waiting = of.waiting;
  return options;
}

}  // namespace

SimulatedController::SimulatedController(SimulatedSession& session,
                                         const std::shared_ptr<const WorldModel>& model,
                                         const Options& options, Violations& violations)
    : session_(&session),
      model_(model),
      options_(options),
      violations_(&violations),
      goals_(std::make_shared<GoalDevice::Orders>()),
      server_(*this, options.device),
      rng_(options.seed),
      hand_(options.id, violations),
      hosts_(options.id, options.device, violations),
      ways_(options.id, violations),
      view_(options.id, *model, violations) {
  std::unique_ptr<Device> device;
  if (options.device) {
    rig_ = std::make_unique<SimulatedDeviceProcess>(options.seed + 1, options.id, violations);
    handle_ = rig_->MakeDevice();
    auto space = std::make_unique<Workspace>(*handle_);
    space_ = space.get();
    device = std::move(space);
  } else {
    auto goal_device = std::make_unique<GoalDevice>(goals_);
    device_ = goal_device.get();
    device = std::move(goal_device);
  }
  member_ = session.Add(
      std::make_unique<PeerNode>(model, std::move(device), kSceneHash, OptionsOf(options)),
      options.id, options.clock);
  ControlScene scene = ControlSceneOf(*model);
  scene.number = 1;
  scene.session = "simulated";
  scene.self = options.id;
  server_.OnScene(scene, LocalNow());
}

bool SimulatedController::at_rest() const {
  const Ownership& ownership = node().peer().ownership();
  const bool requested = std::ranges::any_of(coming_, [](const HostMessage& message) {
    return !message.is_goal;
  });
  return ownership.held() < 0 && ownership.wanted() < 0 && !hosts_.waits() && !requested;
}

void SimulatedController::Log(const std::string& line) const {
  if (!options_.log) return;
  options_.log(Text("%7.3f s: ", ToSeconds(session_->now_ns()) - 1.0) + options_.name + " " + line);
}

void SimulatedController::BeforeFrame() {
  if (running() && device_ != nullptr) device_->See(SeePart(node(), *device_));
}

void SimulatedController::AfterFrame(const TrueHolders& holders) {
  if (!running()) return;
  ++frame_;
  LookOn();
  if (frame_ % facts_period_ == 0) {
    FillFacts(node(), device_, frame_, LocalNow(), facts_);
    fresh_ = true;
  }
  if (frame_ % kNewsFrames == 0) {
    const auto lines =
        node().TakeNotifications([this](const Notification& news, const std::string& line) {
          server_.OnNews(news, line);
        });
    for (const std::string& line : lines) Log("is told: " + line);
  }
  if (frame_ % kPeersFrames == 0) TellPeers();
  Tick(holders);
}

void SimulatedController::TellPeers() {
  std::vector<SnapshotPeer> peers;
  for (const PeerDirectory::Entry& entry : node().directory().Entries()) {
    SnapshotPeer& peer = peers.emplace_back();
    peer.id = entry.info.peer;
    peer.name = node().directory().NameOf(entry.info.peer);
    peer.active = entry.info.role == Role::kActive;
    peer.here = entry.presence == PeerDirectory::Presence::kHere;
    peer.refused = entry.refused;
  }
  server_.OnPeers(std::move(peers));
}

void SimulatedController::Send(HostMessage message) {
  if (message.is_goal && message.goal.kind != HostGoal::Kind::kGoodbye) {
    // only the newest of the waiting goals counts
    std::erase_if(coming_, [&](const HostMessage& other) {
      return other.is_goal && other.host == message.host &&
             (halted_ns_ != 0 || other.due_ns >= message.due_ns) &&
             other.goal.kind != HostGoal::Kind::kGoodbye;
    });
  }
  coming_.push_back(std::move(message));
}

void SimulatedController::Attach(HostId host) {
  mail_[host] = {};
  view_.OnHost(host, session_->now_ns());
}

void SimulatedController::Detach(HostId host) {
  mail_.erase(host);
  view_.OnHostGone(host);
}

HostMail SimulatedController::TakeMail(HostId host) {
  return std::exchange(mail_[host], {});
}

void SimulatedController::Type(bool stop) {
  if (!running()) return;
  stop ? server_.Stop() : server_.Resume();
  hosts_.OnStop(stop, session_->now_ns());
}

void SimulatedController::Halt(bool halted) {
  const std::int64_t now_ns = session_->now_ns();
  if (halted == (halted_ns_ != 0)) return;
  session_->Halt(member_, halted);
  if (!halted) {
    hosts_.OnWoken(now_ns - halted_ns_, now_ns);
    view_.OnWoken(now_ns);
  }
  halted_ns_ = halted ? now_ns : 0;
}

void SimulatedController::Tick(const TrueHolders& holders) {
  const std::int64_t now_ns = session_->now_ns();
  for (const bool goals : {true, false}) {
    // goals and requests each in their order
    for (std::size_t i = 0; i < coming_.size();) {
      if (coming_[i].is_goal != goals || coming_[i].due_ns > now_ns) {
        ++i;
        continue;
      }
      HostMessage message = std::move(coming_[i]);
      coming_.erase(coming_.begin() + static_cast<std::ptrdiff_t>(i));
      Deliver(message);
    }
  }
  for (std::size_t i = 0; i < jobs_.size();) {
    if (jobs_[i].due_ns > now_ns) {
      ++i;
      continue;
    }
    const Job job = jobs_[i];
    jobs_.erase(jobs_.begin() + static_cast<std::ptrdiff_t>(i));
    server_.OnDone(job.number, job.ok ? Answer{true, ""} : Answer{false, "it cannot be done"});
  }
  if (std::exchange(fresh_, false)) server_.OnFacts(facts_, LocalNow());
  server_.Tick(LocalNow());
  GiveAnswers();
  for (const std::string& line : server_.TakeLines()) Log("says: " + line);
  if (now_ns < next_snapshot_ns_) return;
  const double rate_hz = server_.rate_hz();
  const auto period_ns =
      rate_hz > 0 ? static_cast<std::int64_t>(std::llround(1e9 / rate_hz)) : kIdleNs;
  next_snapshot_ns_ = std::max(next_snapshot_ns_ + period_ns, now_ns);
  facts_period_ = static_cast<std::uint32_t>(
      std::clamp(1e-6 * static_cast<double>(period_ns), 1.0, rate_hz > 0 ? 10.0 : 50.0));
  GiveSnapshot(holders);
}

void SimulatedController::Deliver(HostMessage& message) {
  if (!message.is_goal) return DeliverRequest(message);
  if (message.goal.kind == HostGoal::Kind::kGoodbye) Log("hears " + message.name + " say goodbye");
  hosts_.OnGoal(message.host, message.goal, session_->now_ns());
  server_.OnGoal(message.host, message.goal, LocalNow());
}

void SimulatedController::DeliverRequest(HostMessage& message) {
  const HostId host = message.host;
  if (const auto* back = std::get_if<RetraceRequest>(&message.request)) {
    ways_.OnRequest(host, message.number, *back);
  }
  if (const auto* parameter = std::get_if<SetParameterRequest>(&message.request)) {
    parameters_[{host, message.number}] = *parameter;
  }
  GiveAnswers();  // answers to earlier requests
  Log("hears " + message.name + " ask, number " + std::to_string(message.number) + ": " +
      DescribeRequest(message.request));
  server_.OnRequest(host, message.name, message.number, message.request, LocalNow());
  const std::vector<HostAnswer> answers = server_.TakeAnswers();
  const bool refused = std::ranges::any_of(answers, [&](const HostAnswer& answer) {
    return answer.host == host && answer.number == message.number && !answer.answer.ok;
  });
  hosts_.OnRequest(host, message.number, message.request, refused, session_->now_ns());
  for (const HostAnswer& answer : answers) GiveAnswer(answer);
}

void SimulatedController::GiveAnswers() {
  for (const HostAnswer& answer : server_.TakeAnswers()) GiveAnswer(answer);
}

void SimulatedController::GiveAnswer(const HostAnswer& answer) {
  const std::int64_t now_ns = session_->now_ns();
  const auto parameter = parameters_.find({answer.host, answer.number});
  if (parameter != parameters_.end()) {
    if (answer.answer.ok) hand_.Set(parameter->second.name, parameter->second.value, now_ns);
    parameters_.erase(parameter);
  }
  const Answer& reply = answer.answer;
  Log("answers host-" + std::to_string(answer.host) + ", number " + std::to_string(answer.number) +
      (reply.ok ? ": yes " : ": no, ") + reply.reason);
  ways_.OnAnswer(answer.host, answer.number, reply);
  hosts_.OnAnswer(answer.host, answer.number, reply.ok, now_ns);
  const auto mail = mail_.find(answer.host);
  if (mail != mail_.end()) mail->second.answers.push_back(answer);
}

void SimulatedController::GiveSnapshot(const TrueHolders& holders) {
  const auto snapshot = std::make_shared<const ControllerSnapshot>(server_.Snapshot());
  std::vector<HostId> hosts;
  for (auto& [host, mail] : mail_) {
    hosts.push_back(host);
    mail.snapshot = snapshot;
  }
  view_.OnSnapshot(hosts, *snapshot, holders, session_->now_ns());
}

void SimulatedController::LookOn() {
  const std::int64_t now_ns = session_->now_ns();
  const Ownership& ownership = node().peer().ownership();
  const HandObservation sight = See();
  if (device_ != nullptr) hand_.Check(sight);
  ways_.Check(sight, reported_);
  hosts_.Check(sight, ways_.way_m(), hand_.MostSpeed(now_ns));
  std::vector<bool> parked;
  for (std::size_t b = 0; b < model_->bodies.size(); ++b) parked.push_back(ownership.Parks(b));
  view_.Check(frame_, node().world(), ownership.held(), parked, now_ns);
}

HandObservation SimulatedController::See() const {
  const Peer& peer = node().peer();
  HandObservation sight;
  sight.now_ns = session_->now_ns();
  sight.held = peer.ownership().held();
  sight.wanted = peer.ownership().wanted();
  sight.attached = sight.held >= 0 && peer.attached() && peer.held_state() != nullptr;
  if (device_ != nullptr) {
    sight.requested = device_->requested();
    sight.handle = device_->handle().X_WA;
  }
  if (sight.held < 0) return sight;
  const auto held = static_cast<std::size_t>(sight.held);
  std::array<PeerId, kMaxPeers> others{};
  sight.alone = peer.ownership().Holders(held, others) == 0;
  sight.led = peer.separation().guiding();
  sight.mass = model_->bodies[held].inertia.mass;
  sight.body = node().world().state(held);
  sight.X_WG = sight.body.X_WB * peer.grasp();
  sight.pull_B_W = peer.report().hand_B_W;
  return sight;
}

}  // namespace tandem
