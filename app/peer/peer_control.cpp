#include "app/peer/peer_control.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <pthread.h>

#include "app/common/console.h"
#include "collab/controller/fill_facts.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::int64_t kIdleNs = 50'000'000;
constexpr int kTurnsPerLook = 5;  // turns of 20 ms between looks at the peers here
constexpr std::int64_t kPosesPeriodNs = 20'000'000;  // from one copy of the poses to the next
constexpr std::uint64_t kFloodFrom = 200;            // refused samples; fewer are an accident

}  // namespace

Result<std::unique_ptr<PeerControl>> PeerControl::Open(PeerArguments& arguments) {
  Result<std::unique_ptr<ControlPort>> port = ControlPort::Open(arguments.control);
  if (!port) return port.error();
  const bool device_hand = !arguments.hand.empty() || HasDeviceProcess(arguments);
  std::unique_ptr<PeerControl> control(new PeerControl(*std::move(port), arguments, device_hand));
  if (!device_hand) arguments.goals = control->goals_;
  arguments.stop = control->stop_loading_.get_token();
  return control;
}

PeerControl::PeerControl(std::unique_ptr<ControlPort> port, const PeerArguments& arguments,
                         bool device_hand)
    : port_(std::move(port)),
      session_(arguments.session),
      control_(arguments.control),
      server_(*this, device_hand),
      goals_(std::make_shared<GoalDevice::Orders>()),
      space_(arguments.space),
      jobs_thread_([this] {
        RunJobs();
      }),
      thread_([this] {
        Run();
      }) {}

PeerControl::~PeerControl() {
  stop_ = true;
  stop_loading_.request_stop();
  port_->Wake();
  thread_.join();
  {
    const std::lock_guard lock(posted_mutex_);
    jobs_.clear();
  }
  job_came_.notify_all();
  jobs_thread_.join();
  // the last requests have lines too, such as one to end
  for (const std::string& line : lines_) tandem::Say(line);
  meter_.reset();  // the meter posts here
}

void PeerControl::Post(std::function<void(ControlServer&)> what) {
  {
    const std::lock_guard lock(posted_mutex_);
    posted_.push_back(std::move(what));
  }
  port_->Wake();
}

void PeerControl::Run() {
  pthread_setname_np(pthread_self(), "control-port");
  std::int64_t next_ns = 0;
  std::uint64_t seen_frame = 0;
  while (!stop_) {
    const std::int64_t begin_ns = MonotonicNowNs();
    const double rate_hz = server_.rate_hz();
    port_->Wait(rate_hz > 0 ? std::max<std::int64_t>(next_ns - begin_ns, 100'000) : kIdleNs);
    const std::int64_t now_ns = MonotonicNowNs();
    std::vector<std::function<void(ControlServer&)>> posted;
    {
      const std::lock_guard lock(posted_mutex_);
      posted.swap(posted_);
    }
    for (const auto& what : posted) what(server_);
    port_->Take(server_, now_ns);
    const SimulationFacts& facts = facts_.Read();
    const bool fresh = std::exchange(seen_frame, facts.frame) != facts.frame;
    // facts of the previous scene are left out
    if (fresh && facts.scene_number == scene_shown_) {
      server_.OnFacts(facts, now_ns);
      KeepPoses(facts);
    }
    server_.Tick(now_ns);
    for (const HostAnswer& answer : server_.TakeAnswers()) port_->Say(answer);
    if (std::vector<std::string> lines = server_.TakeLines(); !lines.empty()) {
      const std::lock_guard lock(posted_mutex_);
      std::ranges::move(lines, std::back_inserter(lines_));
    }
    // a host that comes must find a snapshot, whatever the rate
    if (now_ns < next_ns) continue;
    const auto period_ns =
        rate_hz > 0 ? static_cast<std::int64_t>(std::llround(1e9 / rate_hz)) : kIdleNs;
    next_ns = std::max(next_ns + period_ns, now_ns);
    facts_period_ = static_cast<std::uint32_t>(
        std::clamp(1e-6 * static_cast<double>(period_ns), 1.0, rate_hz > 0 ? 10.0 : 50.0));
    port_->Say(server_.Snapshot());
  }
}

void PeerControl::KeepPoses(const SimulationFacts& facts) {
  if (facts.time_ns < poses_ns_ + kPosesPeriodNs) return;
  const std::shared_ptr<const WorldModel> model = Model();
  const std::lock_guard lock(posted_mutex_);
  poses_ns_ = facts.time_ns;
  poses_of_ = model.get();
  poses_.clear();
  for (std::uint32_t b = 0; b < facts.body_count; ++b) poses_.push_back(facts.bodies[b].X_WB);
  if (meter_ && measures_of_ == poses_of_) meter_->See(facts.held, poses_);
}

void PeerControl::Begin(const PeerArguments& arguments, SessionSetup& setup) {
  ControlScene scene = ControlSceneOf(*setup.model);
  scene.number = ++scene_number_;
  scene.session = arguments.session;
  scene.self = setup.id;
  scene.own_only = setup.unequal.has_value();
  scene.warnings = setup.warnings;
  device_ = setup.goal_device;
  {
    const std::lock_guard lock(node_mutex_);
    node_ = setup.node.get();
    model_ = setup.model;
  }
  {
    const std::lock_guard lock(stop_mutex_);
    stop_untold_ = device_stopped_;  // an emergency stop outlives the scene
  }
  TellStop();
  std::optional<Load> load;
  {
    const std::lock_guard lock(posted_mutex_);
    load.swap(load_);
  }
  Post([this, scene, load](ControlServer& server) {
    port_->Say(scene, false);
    scene_shown_ = scene.number;
    poses_ns_ = 0;
    server.OnScene(scene, MonotonicNowNs());
    if (!load) return;
    server.OnDone(load->job, load->fault.empty() ? Answer{true, ""} : Answer{false, load->fault});
  });
}

void PeerControl::End() {
  {
    const std::lock_guard lock(node_mutex_);
    node_ = nullptr;
  }
  device_ = nullptr;
  Post([this](ControlServer& server) {
    scene_shown_ = 0;
    std::shared_ptr<DistanceMeter> meter;  // must end without the lock, which it may wait for
    {
      const std::lock_guard lock(posted_mutex_);
      poses_of_ = nullptr;
      meter.swap(meter_);
    }
    server.OnScene(std::nullopt, MonotonicNowNs());
  });
}

void PeerControl::BeforeFrame() noexcept {
  if (device_ != nullptr) device_->See(SeePart(*node_, *device_));
}

void PeerControl::AfterFrame(std::int64_t now_ns) noexcept {
  if (++frame_ % facts_period_.load(std::memory_order_relaxed) != 0) return;
  FillFacts(*node_, device_, frame_, now_ns, facts_.back());
  facts_.back().scene_number = scene_number_;
  facts_.Publish();
}

PeerControl::Wish PeerControl::Tick(PeerTable& table) {
  std::vector<std::string> lines;
  {
    const std::lock_guard lock(posted_mutex_);
    lines.swap(lines_);
  }
  for (const std::string& line : lines) tandem::Say(line);
  if (!flood_told_ && port_->refused() >= kFloodFrom) {
    flood_told_ = true;
    tandem::Say("a program of this user floods the controller, which refuses the excess");
  }
  TellStop();
  if (turns_++ % kTurnsPerLook == 0) {
    Post([peers = Peers(table), colour = node_->colour()](ControlServer& server) {
      server.OnPeers(peers, colour);
    });
  }
  if (quit_) return Wish::kQuit;
  const std::lock_guard lock(posted_mutex_);
  if (load_ && !load_->begun) return Wish::kJoinAgain;
  return Wish::kGoOn;
}

std::vector<SnapshotPeer> PeerControl::Peers(const PeerTable& table) const {
  std::vector<SnapshotPeer> peers;
  for (const PeerDirectory::Entry& entry : node_->directory().Entries()) {
    SnapshotPeer& peer = peers.emplace_back();
    peer.id = entry.info.peer;
    peer.name = node_->directory().NameOf(entry.info.peer);
    peer.active = entry.info.role == Role::kActive;
    peer.here = entry.presence == PeerDirectory::Presence::kHere;
    peer.refused = entry.refused;
    peer.colour = entry.info.colour;
    peer.stopped = entry.info.stopped;
    for (std::uint32_t i = 0; i < table.count; ++i) {
      if (table.rows[i].peer != peer.id) continue;
      peer.delay_s = table.rows[i].delay_s;
      peer.link_force_N = table.rows[i].link_force;
    }
  }
  return peers;
}

PeerNode::OnHand PeerControl::on_hand() {
  return [this](const Notification& news, const std::string& line) {
    Post([news, line](ControlServer& server) {
      server.OnNews(news, line);
    });
  };
}

void PeerControl::OnLine(const std::string& line) {
  Post([line](ControlServer& server) {
    server.OnLine(line);
  });
}

std::shared_ptr<const WorldModel> PeerControl::Model() {
  const std::lock_guard lock(node_mutex_);
  return model_;
}

bool PeerControl::Order(const Command& command) {
  if (command.kind == Command::Kind::kScale && Push(command)) {
    space_->Rescale(command.metres);
    return true;
  }
  const bool stop = command.kind == Command::Kind::kStop;
  if (!stop && command.kind != Command::Kind::kResume) return Push(command);
  Post([stop](ControlServer& server) {
    stop ? server.Stop() : server.Resume();
  });
  return true;
}

void PeerControl::StopDevice(bool stop) {
  const std::lock_guard lock(stop_mutex_);
  device_stopped_ = stop;
  stop_untold_ = !Push({.kind = stop ? Command::Kind::kStop : Command::Kind::kResume});
}

void PeerControl::TellStop() {
  const std::lock_guard lock(stop_mutex_);
  if (!stop_untold_) return;
  stop_untold_ = !Push({.kind = device_stopped_ ? Command::Kind::kStop : Command::Kind::kResume});
}

bool PeerControl::Push(const Command& command) {
  const std::lock_guard lock(node_mutex_);
  return node_ != nullptr && node_->peer().commands().TryPush(command);
}

void PeerControl::Tell(const GoalOrder& order) {
  goals_->newest.back() = order;
  goals_->newest.Publish();
}

}  // namespace tandem
