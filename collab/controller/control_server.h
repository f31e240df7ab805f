#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collab/controller/control_scene.h"
#include "collab/controller/controlled_peer.h"
#include "collab/controller/hand_task.h"
#include "collab/controller/simulation_facts.h"
#include "collab/controller/snapshot.h"

namespace tandem {

using HostId = std::uint64_t;  // random, never 0

/// The newest message of a host's stream: a sign of life, or a goal of its hand.
struct HostGoal {
  enum class Kind : std::uint8_t { kBeat, kPose, kRate, kPush, kGoodbye };
  Kind kind = Kind::kBeat;
  std::uint32_t seq = 0;  // grows with each goal; a beat repeats that of the last goal
  Pose X_WG{};
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();
};

struct HostAnswer {
  HostId host = 0;
  std::uint64_t number = 0;  // number of the request
  Answer answer;
};

/// The controller's side of the command interface (paper §6). A state machine, fed with hosts'
/// requests and goals, with facts of the simulation and the session, and with the time. It gives
/// answers and snapshots, and acts on a ControlledPeer. It has no network, clock or thread.
///
/// The goal of a host that is silent for kQuietNs is held where the hand is. After kLostNs the host
/// is lost, and its hand lets go. A device at the controller keeps its part in hand.
class ControlServer {
 public:
  static constexpr std::int64_t kQuietNs = 150'000'000;
  static constexpr std::int64_t kLostNs = 500'000'000;
  static constexpr std::size_t kMostHosts = 8;
  static constexpr std::size_t kMostWaiting = 64;  // slow requests without an answer, of all hosts
  static constexpr double kMostRate = 1000;        // snapshots a second

  /// `device_hand`: a device at the controller moves the hand, and hosts' goals do not.
  ControlServer(ControlledPeer& peer, bool device_hand);

  /// Sets the simulated scene; nullopt: a scene is being loaded.
  void OnScene(std::optional<ControlScene> scene, std::int64_t now_ns);
  /// Leaves out a repeated request, of the same host and number.
  void OnRequest(HostId host, const std::string& host_name, std::uint64_t number,
                 const ControlRequest& request, std::int64_t now_ns);
  void OnGoal(HostId host, const HostGoal& goal, std::int64_t now_ns);
  /// Takes that a host's process has closed its connection: its hand lets go at once.
  void OnGone(HostId host, std::int64_t now_ns) { Lose(host, "is gone", now_ns); }
  void OnFacts(const SimulationFacts& facts, std::int64_t now_ns);
  /// `colour`: number of our own user's colour; 0: not known.
  void OnPeers(std::vector<SnapshotPeer> peers, std::uint8_t colour = 0) {
    peers_ = std::move(peers);
    colour_ = colour;
    task_.OnPeers(peers_);
  }
  void OnNews(const Notification& news, const std::string& line);
  /// Takes a line for the user that does not come from the hand.
  void OnLine(const std::string& line);
  /// Takes the distance of a moving body from the nearest other one.
  void OnDistance(int held, const SnapshotDistance& distance) {
    distance_held_ = held;
    distance_ = distance;
  }
  void OnDone(std::uint64_t job, const Answer& answer);
  /// Emergency stop, and its end: requested by a host or typed at the controller. The hand lets go
  /// and takes nothing, and its device has no force.
  void Stop();
  void Resume();
  /// Handles hosts that have fallen silent.
  void Tick(std::int64_t now_ns);

  std::vector<HostAnswer> TakeAnswers();
  /// Returns the news for a person at the controller.
  std::vector<std::string> TakeLines();
  /// Returns a snapshot from the newest facts. It lacks the names of bodies and the bodies of each
  /// peer; ControlScene and the bodies' holders have them.
  ControllerSnapshot Snapshot() const;
  /// The highest snapshot rate that a host has asked for; 0: there is no host.
  double rate_hz() const;
  bool stopped() const noexcept { return stopped_; }
  bool loading() const noexcept { return !scene_; }

 private:
  struct Host {
    std::string name;
    std::int64_t received_ns = 0;
    std::uint64_t last_number = 0;
    std::uint32_t goal_seq = 0;
    double rate_hz = 60;
  };
  struct PendingRequest {
    HostId host = 0;
    std::uint64_t number = 0;
  };

  std::size_t scene_bodies() const noexcept { return scene_ ? scene_->bodies.size() : 0; }
  Host* HostOf(HostId id, std::int64_t now_ns);
  void Reply(HostId host, std::uint64_t number, const Answer& answer);
  void Refuse(HostId host, std::uint64_t number, const std::string& why) {
    Reply(host, number, {false, why});
  }
  /// Tells a person at the controller which host saves, loads, resumes or quits.
  void TellOf(const Host& host, const ControlRequest& request, std::int64_t now_ns);
  // carry out a request and return its answer; nullopt where that comes later
  std::optional<Answer> Do(HostId host, std::uint64_t number, const ControlRequest& request,
                           std::int64_t now_ns);
  std::optional<Answer> Do(HostId host, const GrabRequest& request, std::int64_t now_ns);
  std::optional<Answer> Do(HostId host, const AskForRequest& request, std::int64_t now_ns);
  std::optional<Answer> Do(HostId host, const GiveRequest& request, std::int64_t now_ns);
  std::optional<Answer> Do(HostId host, const RetraceRequest& request, std::int64_t now_ns);
  Answer Do(const SetParameterRequest& request);
  Answer Do(const SetClearanceRequest& request);
  Answer Do(const SetViewRequest& request);
  Answer Rescale(double scale);
  void LetGo();
  Answer ChangeWorkspace(const WorkspaceChange& change);
  /// Returns why that host may not use the hand; empty: it may.
  std::string WhyNotHand(HostId host, bool to_take) const;
  /// Returns the moving body of that name, or the reason why there is none.
  Result<int> MovingNamed(const std::string& name) const;
  /// Makes that host's goals count, except those that it has sent already.
  void TakeHand(HostId host);
  void AnswerTasks();
  void Lose(HostId id, const std::string& how, std::int64_t now_ns);
  void AddHand(ControllerSnapshot& snapshot) const;
  void AddContacts(ControllerSnapshot& snapshot) const;

  ControlledPeer* peer_;
  const bool device_hand_;
  std::optional<ControlScene> scene_;
  ControlScene old_scene_;  // while another scene is loaded
  std::map<HostId, Host> hosts_;
  HandTask task_;
  std::uint64_t next_tag_ = 1;
  std::map<std::uint64_t, PendingRequest> tasks_;  // requests that wait for a task's answer, by tag
  HostId hand_host_ = 0;
  HostId clutch_host_ = 0;      // host that has pressed a device's clutch
  bool held_still_ = false;     // the hand's host is quiet, and its goal is held
  std::uint32_t void_seq_ = 0;  // its goals up to this number do not count any more
  bool stopped_ = false;
  bool lets_go_ = false;  // the hand was told to let go, and still has a part
  std::uint64_t next_job_ = 1;
  std::map<std::uint64_t, PendingRequest> jobs_;
  SimulationFacts facts_;
  int distance_held_ = -1;
  SnapshotDistance distance_;
  std::vector<SnapshotPeer> peers_;
  std::uint8_t colour_ = 0;
  std::optional<ControllerSnapshot::Asked> asked_;  // request in the newest line
  std::vector<HostAnswer> answers_;
  std::vector<std::string> lines_;
  std::int64_t told_since_ns_ = 0;  // start of the second in which told_ lines told of requests
  int told_ = 0;
  std::string notifications_;
  std::uint64_t news_count_ = 0;
};

}  // namespace tandem
