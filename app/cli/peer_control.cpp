#include "app/cli/peer_control.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <pthread.h>

#include "app/cli/scene_files.h"
#include "app/cli/talk.h"
#include "collab/controller/fill_facts.h"
#include "collab/dds/control_domain.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::int64_t kIdleNs = 50'000'000;
constexpr int kTurnsPerLook = 5;  // of 20 ms: at who is there

/// What a host is told of the voxels of a mesh.
Answer VoxelsOf(const Scene& scene) {
  const Result<std::shared_ptr<const WorldModel>> model = LoadWorld(scene);
  if (!model) return {false, model.error().what};
  const BodyModel& body = (*model)->bodies.front();
  Result<Voxmap> map = Voxmap{};
  SurfaceDetails details;
  if (const auto fault = MakeMap(scene, (*model)->meshes_W.front(), *map, details)) {
    return {false, fault->what};
  }
  return {true, std::to_string(map->Count().total()) + " voxels, " +
                    std::to_string(body.points.size()) + " points"};
}

}  // namespace

Result<std::unique_ptr<PeerControl>> PeerControl::Open(PeerArguments& arguments) {
  if (arguments.control_domain == arguments.reach.domain) {
    return Error{"--control-domain: the session is on DDS domain " +
                 std::to_string(arguments.reach.domain) + " already, take another"};
  }
  Result<std::unique_ptr<ControlPort>> port =
      ControlPort::Open({.name = arguments.control,
                         .domain = arguments.control_domain,
                         .secured = !arguments.reach.secure.empty()});
  if (!port) return port.error();
  const bool device_hand = !arguments.hand.empty() || HasDeviceProcess(arguments);
  std::unique_ptr<PeerControl> control(
      new PeerControl(*std::move(port), arguments, device_hand));
  if (!device_hand) arguments.goals = control->goals_;
  return control;
}

PeerControl::PeerControl(std::unique_ptr<ControlPort> port, const PeerArguments& arguments,
                         bool device_hand)
    : port_(std::move(port)),
      session_(arguments.session),
      server_(*this, device_hand),
      goals_(std::make_shared<GoalDevice::Orders>()),
      space_(arguments.space),
      thread_([this] {
        Run();
      }) {}

PeerControl::~PeerControl() {
  stop_ = true;
  port_->Wake();
  thread_.join();
  if (voxelizer_.joinable()) voxelizer_.join();
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
    // those of the scene before are left out
    const bool fresh = std::exchange(seen_frame, facts.frame) != facts.frame;
    if (fresh && !server_.loading()) server_.OnFacts(facts, now_ns);
    server_.Tick(now_ns);
    for (const HostAnswer& answer : server_.TakeAnswers()) port_->Say(answer);
    if (std::vector<std::string> lines = server_.TakeLines(); !lines.empty()) {
      const std::lock_guard lock(posted_mutex_);
      std::ranges::move(lines, std::back_inserter(lines_));
    }
    // a host that comes is to find one, whatever the rate
    if (now_ns < next_ns) continue;
    const auto period_ns =
        rate_hz > 0 ? static_cast<std::int64_t>(std::llround(1e9 / rate_hz)) : kIdleNs;
    next_ns = std::max(next_ns + period_ns, now_ns);
    facts_period_ = static_cast<std::uint32_t>(
        std::clamp(1e-6 * static_cast<double>(period_ns), 1.0, rate_hz > 0 ? 10.0 : 50.0));
    port_->Say(server_.Snapshot());
  }
}

void PeerControl::Begin(const PeerArguments& arguments, Joining& joining) {
  ControlScene scene = ControlSceneOf(*joining.model);
  scene.number = ++scene_number_;
  scene.session = arguments.session;
  scene.self = joining.id;
  scene.own_only = joining.unequal.has_value();
  device_ = joining.goal_device;
  {
    const std::lock_guard lock(node_mutex_);
    node_ = joining.node.get();
    model_ = joining.model;
  }
  if (device_stopped_) TellStop();  // an emergency stop outlives the scene
  std::optional<Load> load;
  {
    const std::lock_guard lock(posted_mutex_);
    load.swap(load_);
  }
  Post([this, scene, load](ControlServer& server) {
    port_->Say(scene, false);
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
  Post([](ControlServer& server) {
    server.OnScene(std::nullopt, MonotonicNowNs());
  });
}

void PeerControl::BeforeFrame() noexcept {
  if (device_ != nullptr) device_->See(SeePart(*node_, *device_));
}

void PeerControl::AfterFrame(std::int64_t now_ns) noexcept {
  if (++frame_ % facts_period_.load(std::memory_order_relaxed) != 0) return;
  FillFacts(*node_, device_, frame_, now_ns, facts_.back());
  facts_.Publish();
}

PeerControl::Wish PeerControl::Turn(PeerTable& table) {
  std::vector<std::string> lines;
  {
    const std::lock_guard lock(posted_mutex_);
    lines.swap(lines_);
  }
  for (const std::string& line : lines) tandem::Say(line);
  if (stop_untold_) TellStop();
  if (turns_++ % kTurnsPerLook == 0) {
    Post([peers = Peers(table)](ControlServer& server) {
      server.OnPeers(peers);
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
    for (std::uint32_t i = 0; i < table.count; ++i) {
      if (table.rows[i].peer != peer.id) continue;
      peer.delay_s = table.rows[i].delay_s;
      peer.link_force_N = table.rows[i].link_force;
    }
  }
  return peers;
}

PeerNode::OnHand PeerControl::on_hand() {
  return [this](const HoldingNews& news, const std::string& line) {
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
  const bool stop = command.kind == Command::Kind::kStop;
  if (!stop && command.kind != Command::Kind::kResume) return Push(command);
  Post([stop](ControlServer& server) {
    stop ? server.Stop() : server.Resume();
  });
  return true;
}

void PeerControl::StopDevice(bool stop) {
  device_stopped_ = stop;
  TellStop();
}

void PeerControl::TellStop() {
  using Kind = Command::Kind;
  stop_untold_ = !Push({.kind = device_stopped_ ? Kind::kStop : Kind::kResume});
}

bool PeerControl::Push(const Command& command) {
  const std::lock_guard lock(node_mutex_);
  return node_ != nullptr && node_->peer().commands().TryPush(command);
}

void PeerControl::Tell(const GoalOrder& order) {
  goals_->newest.back() = order;
  goals_->newest.Publish();
}

void PeerControl::Begin(std::uint64_t job, const ControlRequest& request) {
  const auto done = [this, job](const Answer& answer) {
    // from within the server: it has not noted the job yet
    Post([job, answer](ControlServer& server) {
      server.OnDone(job, answer);
    });
  };
  if (const auto* voxelize = std::get_if<VoxelizeRequest>(&request)) {
    return Voxelize(job, *voxelize);
  }
  if (const auto* save = std::get_if<SaveRequest>(&request)) {
    return done(Write(save->file, std::nullopt, false));
  }
  std::string file;
  if (const auto* mesh = std::get_if<LoadMeshRequest>(&request)) {
    const Result<std::filesystem::path> folder = ControlFolder();
    if (!folder) return done({false, folder.error().what});
    const std::filesystem::path scene = *folder / ("with-" + std::to_string(job) + ".json");
    const Answer written = Write(scene,
                                 AddedBody{.name = mesh->body,
                                           .mesh = mesh->file,
                                           .fixed = mesh->fixed,
                                           .shared = mesh->shared,
                                           .mass_kg = mesh->mass_kg},
                                 true);
    if (!written.ok) return done(written);
    file = scene;
  } else if (const auto* load = std::get_if<LoadSceneRequest>(&request)) {
    file = load->file;
  }
  // what can be seen at once is said before the present scene is left
  if (const Result<Scene> scene = LoadNamedScene(file); !scene) {
    return done({false, scene.error().what});
  }
  {
    const std::lock_guard lock(node_mutex_);
    for (const PeerDirectory::Entry& entry : node_->directory().Entries()) {
      if (entry.presence == PeerDirectory::Presence::kHere && entry.refused.empty() &&
          entry.info.role == Role::kActive) {
        return done({false, "others take part in session " + session_ +
                                " with this scene: take another one to a session of its own"});
      }
    }
  }
  const std::lock_guard lock(posted_mutex_);
  if (load_) {
    posted_.push_back([job](ControlServer& server) {
      server.OnDone(job, {false, "another scene is being loaded"});
    });
    return;
  }
  load_ = Load{.job = job, .file = file, .before = {}, .fault = {}, .begun = false};
}

void PeerControl::TakeLoad(PeerArguments& arguments) {
  const std::lock_guard lock(posted_mutex_);
  if (!load_ || load_->begun) return;
  load_->begun = true;
  load_->before = arguments.scene;
  arguments.scene = load_->file;
  arguments.hold.clear();  // it is of the scene before
}

bool PeerControl::RevertLoad(PeerArguments& arguments, const std::string& why) {
  const std::lock_guard lock(posted_mutex_);
  if (!load_ || !load_->begun || !load_->fault.empty()) return false;
  load_->fault = why;
  arguments.scene = load_->before;
  return true;
}

Answer PeerControl::Write(const std::filesystem::path& file, const std::optional<AddedBody>& added,
                          bool overwrite) {
  if (!file.is_absolute()) return {false, file.string() + ": expected an absolute name"};
  const std::shared_ptr<const WorldModel> kept = Model();
  const WorldModel& model = *kept;
  const SimulationFacts& facts = facts_.Read();
  std::vector<Pose> displaced(model.scene.bodies.size());
  for (std::size_t i = 0; i < displaced.size(); ++i) {
    const int moving = model.body_index[i];
    if (moving < 0 || static_cast<std::uint32_t>(moving) >= facts.body_count) continue;
    const auto b = static_cast<std::size_t>(moving);
    displaced[i] = facts.bodies[b].X_WB * model.bodies[b].X_WB0.Inverse();
  }
  const Result<bool> written = WriteSceneAsItStands(model.scene, displaced, added, file, overwrite);
  return written ? Answer{true, file.string()} : Answer{false, written.error().what};
}

void PeerControl::Voxelize(std::uint64_t job, const VoxelizeRequest& request) {
  const auto done = [this, job](const Answer& answer) {
    Post([job, answer](ControlServer& server) {
      server.OnDone(job, answer);
    });
  };
  if (voxelizing_.exchange(true)) return done({false, "another mesh is being voxelized"});
  if (voxelizer_.joinable()) voxelizer_.join();
  Scene scene = Model()->scene;
  if (request.voxel_size_m > 0) scene.voxel_size = request.voxel_size_m;
  scene.pairs.clear();
  scene.hands.clear();
  scene.bodies = {SceneBody{}};
  scene.bodies.front().name = "mesh";
  scene.bodies.front().mesh = request.file;
  scene.bodies.front().mass = 1;
  voxelizer_ = std::thread([this, scene, done] {
    const Answer answer = VoxelsOf(scene);
    voxelizing_ = false;
    done(answer);
  });
}

}  // namespace tandem
