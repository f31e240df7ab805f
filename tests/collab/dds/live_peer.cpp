#include "tests/collab/dds/live_peer.h"

#include <random>
#include <utility>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace tandem::testing {
namespace {

using std::chrono::steady_clock;

std::int64_t Now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

std::string RandomSession() {
  std::random_device random;
  return "test-" + std::to_string(random()) + "-" + std::to_string(random());
}

std::uint16_t FreePortPair() {
  const auto try_port = [](std::uint16_t port) -> std::uint16_t {  // 0: any; gives 0 if taken
    const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    socklen_t size = sizeof address;
    const bool bound = bind(probe, reinterpret_cast<sockaddr*>(&address), size) == 0;
    getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size);
    close(probe);
    return bound ? ntohs(address.sin_port) : std::uint16_t{0};
  };
  for (;;) {
    const std::uint16_t port = try_port(0);
    if (port < 65535 && try_port(static_cast<std::uint16_t>(port + 1)) != 0) return port;
  }
}

DdsOptions LoopbackOptions(const std::string& session, PeerId peer, Role role) {
  DdsOptions options;
  options.session = session;
  options.peer = peer;
  options.role = role;
  options.interface = "lo";
  options.objects = {7};
  return options;
}

ObjectState SampleState(PeerId peer, std::uint32_t seq) {
  ObjectState state;
  state.peer = peer;
  state.object = 7;
  state.epoch = 2;
  state.seq = seq;
  state.flags = 5;
  state.sample_ns = Now_ns();
  state.X_WB = {Quat(0.5, -0.5, 0.5, 0.5), Vec3(0.125, -2, 3)};
  state.V_WB = {Vec3(1, 2, 3), Vec3(-4, 5, 6)};
  state.contact_B_W = {Vec3(0.25, 0, -1), Vec3(9, 8, 7)};
  return state;
}

CouplingLinks SampleLinks(PeerId peer, std::uint32_t seq) {
  CouplingLinks links;
  links.from = peer;
  links.object = 7;
  links.seq = seq;
  links.sample_ns = Now_ns();
  links.count = 2;
  links.entries[0] = {11, 123456789, 800.5, 0.25, {Vec3(1, 2, 3), Vec3(4, 5, 6)}};
  links.entries[1] = {12, -5, 0, 0, {}};
  return links;
}

ViewFrame SampleView(PeerId peer, std::uint32_t seq) {
  ViewFrame frame;
  frame.peer = peer;
  frame.seq = seq;
  frame.sample_ns = Now_ns();
  frame.delay_ms = 12.5F;
  frame.count = 1;
  frame.bodies[0] = {
      7, ViewBody::kHeld, {Quat(0.5, 0.5, -0.5, 0.5), Vec3(1, -2, 0.25)}, Vec3(3, 2, 1)};
  return frame;
}

PeerInfo SampleInfo(PeerId peer, Role role, std::uint32_t beat) {
  PeerInfo info;
  info.peer = peer;
  info.beat = beat;
  info.role = role;
  info.name = "Ada";
  info.scene_hash = 42;
  info.claims = {{7, 2, true}, {9, 3, false}};
  return info;
}

SceneManifest SampleScene(PeerId peer) {
  SceneManifest manifest;
  manifest.offered_by = peer;
  manifest.content_hash = 42;
  manifest.name = "bracket";
  manifest.file = "/tmp/bracket.json";
  manifest.voxel_size = 0.002;
  manifest.bodies = {{"plate", 1}, {"bracket", 2}, {"pin", 3}};
  return manifest;
}

Recorder::Heard Recorder::Now() const {
  const std::scoped_lock lock(mutex_);
  return received_;
}

bool Recorder::WaitFor(std::function<bool(const Heard&)> holds,
                       std::chrono::milliseconds deadline) const {
  std::unique_lock lock(mutex_);
  return changed_.wait_for(lock, deadline, [&] {
    return holds(received_);
  });
}

void Recorder::OnState(const ObjectState& state, std::int64_t arrival_ns) {
  const std::scoped_lock lock(mutex_);
  if (!received_.states.contains(state.peer)) tell("state", state.peer);
  received_.states[state.peer] = state;
  state_ages_ns.push_back(arrival_ns - state.sample_ns);
  changed_.notify_all();
}
void Recorder::OnLinks(const CouplingLinks& links, std::int64_t /*arrival_ns*/) {
  const std::scoped_lock lock(mutex_);
  if (!received_.links.contains(links.from)) tell("links", links.from);
  received_.links[links.from] = links;
  changed_.notify_all();
}
void Recorder::OnView(const ViewFrame& frame, std::int64_t /*arrival_ns*/) {
  const std::scoped_lock lock(mutex_);
  if (!received_.views.contains(frame.peer)) tell("view", frame.peer);
  received_.views[frame.peer] = frame;
  changed_.notify_all();
}
void Recorder::OnPeerInfo(const PeerInfo& info, std::int64_t /*arrival_ns*/) {
  const std::scoped_lock lock(mutex_);
  if (!received_.infos.contains(info.peer)) tell("info", info.peer);
  received_.infos[info.peer] = info;
  ++received_.info_count[info.peer];
  changed_.notify_all();
}
void Recorder::OnPeerLeft(PeerId peer) {
  const std::scoped_lock lock(mutex_);
  tell("left", peer);
  received_.infos.erase(peer);
  ++received_.left[peer];
  changed_.notify_all();
}
void Recorder::OnPeerLost(PeerId peer) {
  const std::scoped_lock lock(mutex_);
  tell("lost", peer);
  received_.infos.erase(peer);
  ++received_.lost[peer];
  changed_.notify_all();
}
void Recorder::OnEvent(const Event& event, std::int64_t /*arrival_ns*/) {
  const std::scoped_lock lock(mutex_);
  tell("event", event.peer);
  received_.events.push_back(event);
  changed_.notify_all();
}
void Recorder::OnScene(const SceneManifest& manifest) {
  const std::scoped_lock lock(mutex_);
  tell("scene", manifest.content_hash);
  received_.scenes.push_back(manifest);
  changed_.notify_all();
}

void Recorder::OnTwin(const PeerInfo& info) {
  const std::scoped_lock lock(mutex_);
  tell("twin", info.peer);
  ++received_.twins;
  changed_.notify_all();
}
void Recorder::OnDropped(PeerId from, Drop reason) {
  const std::scoped_lock lock(mutex_);
  ++received_.dropped[{from, reason}];
  changed_.notify_all();
}

LivePeer::LivePeer(std::unique_ptr<Transport> transport, DdsOptions options, PeerId claimed)
    : transport_(std::move(transport)),
      options_(std::move(options)),
      claimed_(claimed),
      thread_([this] {
        Run();
      }) {}

LivePeer::~LivePeer() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void LivePeer::Leave() {
  stop_ = true;
  thread_.join();
  transport_->Leave();
}

void LivePeer::Run() {
  const bool active = options_.role == Role::kActive;
  if (active) transport_->Publish(SampleScene(options_.peer));
  auto next = steady_clock::now();
  for (std::uint32_t tick = 0; !stop_; ++tick) {
    if (tick % 200 == 0) transport_->Publish(SampleInfo(options_.peer, options_.role, tick / 200));
    if (active) {
      if (claimed_ != options_.peer) {
        transport_->Publish(SampleState(claimed_, tick), SampleLinks(claimed_, tick));
      }
      // as for a hand that others join and leave
      if (tick % 2 == 0) {
        transport_->Publish(SampleState(options_.peer, tick), SampleLinks(options_.peer, tick));
      } else {
        transport_->Publish(SampleState(options_.peer, tick));
      }
      if (tick % 16 == 0) transport_->Publish(SampleView(options_.peer, tick));
    }
    next += std::chrono::milliseconds(1);
    std::this_thread::sleep_until(next);
  }
}

}  // namespace tandem::testing
