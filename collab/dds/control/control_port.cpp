#include "collab/dds/control/control_port.h"

#include <algorithm>
#include <atomic>
#include <deque>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "collab/dds/control/control_folder.h"
#include "collab/dds/control/control_packet.h"
#include "collab/dds/control/control_socket.h"
#include "collab/dds/control/name_lock.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/wire/control_wire.h"

namespace tandem {

namespace {

using Outcome = ControlConnection::Outcome;

constexpr std::size_t kMostPrograms = 32;             // connected at once
constexpr std::size_t kMostWaitingBytes = 1U << 20U;  // to a program that does not read
constexpr double kMessagesPerSecond = 20'000;         // messages of a program
constexpr double kMessagesAtOnce = 20'000;            // the same
constexpr int kMostATurn = 2000;             // messages of a program, so that all get turns
constexpr std::int64_t kPaceNs = 5'000'000;  // between looks at a program that was paced

/// A program that is connected, and the host as which it speaks.
struct ConnectedHost {
  ControlConnection connection;
  HostId id = 0;                          // 0: it has said nothing yet
  std::deque<std::vector<char>> waiting;  // messages that must arrive, when there is room
  std::size_t waiting_bytes = 0;
  double pace = kMessagesAtOnce;  // messages that are taken now
  std::int64_t paced_ns = 0;      // time of that
  bool gone = false;
};

class SocketControlPort final : public ControlPort {
 public:
  SocketControlPort(NameLock lock, ControlListener listener)
      : lock_(std::move(lock)),
        listener_(std::move(listener)),
        wake_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    std::random_device random;
    while (id_ == 0) id_ = std::uint64_t{random()} << 32U | random();
  }

  void Wait(std::int64_t at_most_ns) override {
    std::vector<pollfd> waits{{listener_.descriptor(), POLLIN, 0}, {wake_.get(), POLLIN, 0}};
    for (ConnectedHost& host : hosts_) {
      SendWaiting(host);
      const bool reads = host.pace >= 1;
      if (!reads) at_most_ns = std::min(at_most_ns, kPaceNs);
      const int events = (reads ? POLLIN : 0) | (host.waiting.empty() ? 0 : POLLOUT);
      waits.push_back({host.connection.descriptor(), static_cast<short>(events), 0});
    }
    const timespec time{at_most_ns / 1'000'000'000, at_most_ns % 1'000'000'000};
    ppoll(waits.data(), waits.size(), &time, nullptr);
    std::uint64_t times = 0;
    static_cast<void>(!read(wake_.get(), &times, sizeof times));
  }
  void Wake() override {
    const std::uint64_t once = 1;
    static_cast<void>(!write(wake_.get(), &once, sizeof once));
  }

  void Take(ControlServer& server, std::int64_t now_ns) override {
    TakeArrivals(now_ns);
    for (ConnectedHost& host : hosts_) TakeFrom(host, server, now_ns);
    for (const ConnectedHost& host : hosts_) {
      if (host.gone && host.id != 0) server.OnGone(host.id, now_ns);
    }
    std::erase_if(hosts_, [](const ConnectedHost& host) {
      return host.gone;
    });
  }

  void Say(const HostAnswer& answer) override {
    tandem_control_Answer wire{};
    ToWire(answer, wire);
    for (ConnectedHost& host : hosts_) {
      if (host.id == answer.host) Deliver(host, PacketOf(wire));
    }
  }
  void Say(const ControlScene& scene, bool loading) override {
    tandem_control_Scene wire{};
    std::vector<tandem_control_SceneBody> room;
    ToWire(scene, loading, wire, room);
    wire.controller = id_;
    scene_ = PacketOf(wire);
    for (ConnectedHost& host : hosts_) Deliver(host, scene_);
  }
  void Say(const ControllerSnapshot& snapshot) override {
    if (hosts_.empty()) return;
    tandem_control_Snapshot wire{};
    ToWire(snapshot, snapshot.self, wire, room_);
    const std::vector<char> packet = PacketOf(wire);
    for (ConnectedHost& host : hosts_) {
      // a host without room for it gets a later one
      if (host.waiting.empty() && !packet.empty()) Note(host, host.connection.Send(packet));
    }
  }
  std::uint64_t refused() const noexcept override {
    return refused_.load(std::memory_order_relaxed);
  }

 private:
  void CountRefused() noexcept { refused_.fetch_add(1, std::memory_order_relaxed); }
  static void Note(ConnectedHost& host, Outcome outcome) noexcept {
    if (outcome == Outcome::kGone) host.gone = true;
  }

  void TakeArrivals(std::int64_t now_ns) {
    for (std::size_t looks = 0; looks < kMostPrograms; ++looks) {
      ControlListener::Arrival arrival = listener_.Accept();
      if (arrival.anothers) CountRefused();
      if (!arrival.host && !arrival.anothers) return;
      if (!arrival.host || hosts_.size() >= kMostPrograms) continue;
      hosts_.push_back({.connection = *std::move(arrival.host), .waiting = {}, .paced_ns = now_ns});
      if (!scene_.empty()) Deliver(hosts_.back(), scene_);
    }
  }

  void TakeFrom(ConnectedHost& host, ControlServer& server, std::int64_t now_ns) {
    const double passed_s =
        1e-9 * static_cast<double>(now_ns - std::exchange(host.paced_ns, now_ns));
    host.pace = std::min(kMessagesAtOnce, host.pace + kMessagesPerSecond * passed_s);
    for (int taken = 0; taken < kMostATurn && !host.gone; ++taken) {
      if (host.pace < 1) return CountRefused();
      const Outcome outcome = host.connection.Receive(packet_);
      if (outcome == Outcome::kLater) return;
      Note(host, outcome);
      host.pace -= 1;
      if (outcome == Outcome::kUnusable ||
          (outcome == Outcome::kDone && !Use(host, server, now_ns))) {
        CountRefused();
      }
    }
  }

  // Hands the packet that has come to the server. False: no sound host sends it.
  bool Use(ConnectedHost& host, ControlServer& server, std::int64_t now_ns) {
    const std::optional<ControlTopic> topic = TopicOf(packet_);
    bool used = false;
    if (topic == ControlTopic::kGoal) {
      UsePacket<tandem_control_Goal>(packet_, *topic, [&](const tandem_control_Goal& wire) {
        HostGoal goal;
        used = SpeaksAs(host, wire.host) && FromWire(wire, goal);
        if (used) server.OnGoal(wire.host, goal, now_ns);
      });
    }
    if (topic == ControlTopic::kRequest) {
      UsePacket<tandem_control_Request>(packet_, *topic, [&](const tandem_control_Request& wire) {
        used = SpeaksAs(host, wire.host);
        if (used) Use(wire, server, now_ns);
      });
    }
    return used;
  }

  void Use(const tandem_control_Request& wire, ControlServer& server, std::int64_t now_ns) {
    const std::optional<ControlRequest> request =
        wire.version == kControlVersion ? FromWire(wire) : std::nullopt;
    if (request) {
      server.OnRequest(wire.host, TextFromWire(wire.host_name), wire.number, *request, now_ns);
      return;
    }
    Say(HostAnswer{
        wire.host,
        wire.number,
        {false, wire.version == kControlVersion
                    ? "a request that is none"
                    : "this controller speaks version " + std::to_string(kControlVersion) +
                          " of the command interface, not " + std::to_string(wire.version)}});
  }

  // A connection speaks as one host, and no two connections as the same: so no program mutes
  // another, takes its answers or goes on with its numbers.
  bool SpeaksAs(ConnectedHost& host, HostId id) {
    if (host.id != 0) return host.id == id;
    const bool anothers = std::ranges::any_of(hosts_, [id](const ConnectedHost& other) {
      return other.id == id && !other.gone;
    });
    if (id == 0 || anothers) return false;
    host.id = id;
    return true;
  }

  // Sends a message that must arrive. A program that reads nothing for long is disconnected.
  static void Deliver(ConnectedHost& host, std::vector<char> packet) {
    host.waiting_bytes += packet.size();
    host.waiting.push_back(std::move(packet));
    SendWaiting(host);
    if (host.waiting_bytes > kMostWaitingBytes) host.gone = true;
  }
  static void SendWaiting(ConnectedHost& host) {
    while (!host.waiting.empty()) {
      const Outcome outcome = host.connection.Send(host.waiting.front());
      Note(host, outcome);
      if (outcome == Outcome::kLater) return;
      host.waiting_bytes -= host.waiting.front().size();
      host.waiting.pop_front();
    }
  }

  NameLock lock_;
  ControlListener listener_;
  OwnDescriptor wake_;
  std::atomic<std::uint64_t> refused_ = 0;
  std::uint64_t id_ = 0;
  std::vector<ConnectedHost> hosts_;
  std::vector<char> scene_;  // packet of the present scene, for programs that come
  std::vector<char> packet_;
  SnapshotBuffers room_;
};

}  // namespace

Result<std::unique_ptr<ControlPort>> ControlPort::Open(const std::string& name) {
  if (!IsMemberName(name)) {
    return Error{"'" + name + "' is no name for a controller: letters, digits, '.', '_', " +
                 "'-', at most 64"};
  }
  const Result<std::filesystem::path> folder = ControlFolder();
  if (!folder) return folder.error();
  NameLock::Sweep(*folder);
  Result<NameLock> lock = NameLock::Take(*folder, name);
  if (!lock) return lock.error();
  Result<ControlListener> listener = ControlListener::Open(*folder, name);
  if (!listener) return listener.error();
  return std::unique_ptr<ControlPort>(
      std::make_unique<SocketControlPort>(*std::move(lock), *std::move(listener)));
}

}  // namespace tandem
