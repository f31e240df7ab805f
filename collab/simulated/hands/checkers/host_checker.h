#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "collab/controller/control_server.h"
#include "collab/simulated/hands/checkers/goal_hand_checker.h"

namespace tandem {

/// Judges how a controller serves its hosts (docs/controller.md), by its inputs from them, its
/// answers, and the hand's motion, in true time.
///
/// - Each request has one answer, within a bounded time.
/// - The hand belongs to the host that was last allowed to take something. While that host lives
///   and holds something, other hosts' grabs are refused, and only its messages move the goal.
/// - When a host is silent for 0.15 s, its goal is held where the hand is. The hand lets go 0.5 s
///   after the host's last message.
/// - During an emergency stop nothing is in hand or asked for.
/// - The hand never goes to a goal that is no place. It goes to the newest goal sent since the part
///   was asked for.
///
/// Time in which the controller is stopped counts for no host.
class HostChecker {
 public:
  HostChecker(PeerId id, bool device_hand, Violations& violations)
      : id_(id), device_hand_(device_hand), violations_(&violations) {}

  // the controller's inputs
  void OnGoal(HostId host, const HostGoal& goal, std::int64_t now_ns);
  /// `refused`: the request was refused at once.
  void OnRequest(HostId host, std::uint64_t number, const ControlRequest& request, bool refused,
                 std::int64_t now_ns);
  void OnAnswer(HostId host, std::uint64_t number, bool ok, std::int64_t now_ns);
  /// Notes that a person types 'stop' or 'resume' at the controller.
  void OnStop(bool stop, std::int64_t now_ns);
  /// Notes that the controller has stood still for so long, until `now_ns`.
  void OnWoken(std::int64_t halted_ns, std::int64_t now_ns);

  /// Judges a frame; call it after every frame. `way_m` is how far this hand has moved parts so
  /// far, `speed` the highest speed of the goal.
  void Check(const HandObservation& sight, double way_m, double speed);
  /// Returns whether a request waits for its answer.
  bool waits() const { return !waiting_.empty(); }

 private:
  struct Waiting {
    std::int64_t since_ns = 0;
    double most_s = 0;
    bool back = false;
  };
  struct Host {
    std::int64_t received_ns = 0;
    std::uint32_t seq = 0;       // number of its newest goal
    std::int64_t said_ns = 0;    // time of its newest goal
    std::optional<Pose> stated;  // its newest goal
    std::int64_t moved_ns = 0;   // time until which that goal may move the hand's goal; 0: there is
                                 // none
  };

  void Lose(HostId host, std::int64_t now_ns);
  void CheckAnswers(const HandObservation& sight, double way_m);
  void CheckStop(const HandObservation& sight);
  void CheckSilence(const HandObservation& sight, double speed);
  void CheckGoal(const HandObservation& sight);
  void CheckNewestGoal(const HandObservation& sight);
  bool MayMove(const HandObservation& sight) const;
  double Silence(std::int64_t now_ns) const;

  PeerId id_;
  bool device_hand_;
  Violations* violations_;
  std::map<HostId, Host> hosts_;
  std::map<std::pair<HostId, std::uint64_t>, Waiting> waiting_;
  std::set<std::pair<HostId, std::uint64_t>> answered_;
  HostId owner_ = 0;             // host that has the hand
  std::int64_t owner_ns_ = 0;    // time since which it has the hand
  std::int64_t asked_ns_ = 0;    // time at which it last asked for something
  std::int64_t lost_ns_ = 0;     // time at which the last owner was lost; 0: the hand has let go
                                 // since
  std::int64_t back_ns_ = 0;     // time at which a part last was on its way back
  std::int64_t stopped_ns_ = 0;  // time since which an emergency stop holds; 0: none does
  std::int64_t woken_ns_ = 0;
  bool stop_ = false;
  std::int64_t held_ns_ = 0;     // time since which something is in hand; 0: nothing is
  std::int64_t grasped_ns_ = 0;  // time since which it is grasped
  std::optional<HandObservation> before_;
};

}  // namespace tandem
