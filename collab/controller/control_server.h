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

/// What a host's stream says, newest first: that it lives, and what its hand means.
struct HostGoal {
  enum class Kind : std::uint8_t { kBeat, kPose, kRate, kPush, kGoodbye };
  Kind kind = Kind::kBeat;
  std::uint32_t seq = 0;  // grows with each goal; a beat has that of the goal before it
  Pose X_WG{};
  Vec3 linear = Vec3::Zero();
  Vec3 angular = Vec3::Zero();
};

struct HostAnswer {
  HostId host = 0;
  std::uint64_t number = 0;  // of the request
  Answer answer;
};

/// The controller's side of the command interface (paper §6), as a state machine: fed with hosts'
/// requests and goals, with what the simulation and the session say, and with the time. It gives
/// answers and snapshots, and acts on a ControlledPeer. No network, no clock, no thread.
///
/// A host that is silent for kQuietNs has its goal held where the hand is; after kLostNs it is lost
/// and what its hand holds is let go of. The part of a device at the controller stays in hand.
class ControlServer {
 public:
  static constexpr std::int64_t kQuietNs = 150'000'000;
  static constexpr std::int64_t kLostNs = 500'000'000;
  static constexpr std::size_t kMostHosts = 8;
  static constexpr std::size_t kMostWaiting = 64;  // requests without an answer, of all hosts
  static constexpr double kMostRate = 1000;        // snapshots a second

  /// `device_hand`: a device at the controller moves the hand, hosts' goals do not.
  ControlServer(ControlledPeer& peer, bool device_hand);

  /// From now on that one is simulated; nothing: it is being loaded.
  void OnScene(std::optional<ControlScene> scene, std::int64_t now_ns);
  /// A second one of the same host and number is left out.
  void OnRequest(HostId host, const std::string& host_name, std::uint64_t number,
                 const ControlRequest& request, std::int64_t now_ns);
  void OnGoal(HostId host, const HostGoal& goal, std::int64_t now_ns);
  void OnFacts(const SimulationFacts& facts, std::int64_t now_ns);
  void OnPeers(std::vector<SnapshotPeer> peers) { peers_ = std::move(peers); }
  void OnNews(const HoldingNews& news, const std::string& line);
  /// A line for the user, of what does not come from the hand.
  void OnLine(const std::string& line);
  /// Of a moving body to what is nearest to it.
  void OnDistance(int held, const SnapshotDistance& distance) {
    distance_held_ = held;
    distance_ = distance;
  }
  void OnDone(std::uint64_t job, const Answer& answer);
  /// Emergency stop, and its end: asked for by a host or typed at the controller. The hand lets go,
  /// takes nothing, and its device has no force.
  void Stop();
  void Resume();
  /// Of hosts that have fallen silent.
  void Tick(std::int64_t now_ns);

  std::vector<HostAnswer> TakeAnswers();
  /// What happened that a person at the controller should read.
  std::vector<std::string> TakeLines();
  /// As of the newest facts. Names of bodies, and what each peer holds, are left out: ControlScene
  /// and the bodies' holders have them.
  ControllerSnapshot Snapshot() const;
  /// Of snapshots, the highest that a host has asked for; 0: there is no host.
  double rate_hz() const;
  bool stopped() const noexcept { return stopped_; }
  bool loading() const noexcept { return !scene_; }

 private:
  struct Host {
    std::string name;
    std::int64_t heard_ns = 0;
    std::uint64_t last_number = 0;
    std::uint32_t goal_seq = 0;
    double rate_hz = 60;
  };
  struct Asked {
    HostId host = 0;
    std::uint64_t number = 0;
  };

  Host* HostOf(HostId id, std::int64_t now_ns);
  void Reply(HostId host, std::uint64_t number, const Answer& answer);
  void Refuse(HostId host, std::uint64_t number, const std::string& why) {
    Reply(host, number, {false, why});
  }
  // what a request comes to: an answer, or nothing where that comes later
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
  /// Why that host may not use the hand now; empty: it may.
  std::string WhyNotHand(HostId host, bool to_take) const;
  /// The moving body of that name, or why there is none.
  Result<int> MovingNamed(const std::string& name) const;
  /// From now on that host's goals count, but not those that it has said already.
  void TakeHand(HostId host);
  void AnswerTasks();
  void Lose(HostId id, const std::string& how, std::int64_t now_ns);
  void AddHand(ControllerSnapshot& snapshot) const;
  void AddContacts(ControllerSnapshot& snapshot) const;

  ControlledPeer* peer_;
  const bool device_hand_;
  std::optional<ControlScene> scene_;
  ControlScene old_scene_;  // while another is loaded
  std::map<HostId, Host> hosts_;
  HandTask task_;
  std::uint64_t next_tag_ = 1;
  std::map<std::uint64_t, Asked> tasks_;  // who waits for the answer, by tag
  HostId hand_host_ = 0;
  HostId clutch_host_ = 0;      // that has pressed a device's clutch
  bool held_still_ = false;     // its goal, for it is quiet
  std::uint32_t void_seq_ = 0;  // its goals up to this one are not to be gone to any more
  bool stopped_ = false;
  bool lets_go_ = false;  // was told to, and has something still
  std::uint64_t next_job_ = 1;
  std::map<std::uint64_t, Asked> jobs_;
  SimulationFacts facts_;
  int distance_held_ = -1;
  SnapshotDistance distance_;
  std::vector<SnapshotPeer> peers_;
  std::vector<HostAnswer> answers_;
  std::vector<std::string> lines_;
  std::string news_;
  std::uint64_t news_count_ = 0;
};

}  // namespace tandem
