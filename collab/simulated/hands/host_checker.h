#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "collab/controller/control_server.h"
#include "collab/simulated/hands/goal_hand_checker.h"

namespace tandem {

/// What a controller owes its hosts (docs/controller.md), judged by what reaches it from them, what
/// it answers, and what the hand then does; in true time.
///
/// - Each request has one answer, within a bounded time.
/// - The hand is that of the host that was last allowed to take something: while it lives and holds
///   something, the others' grabs are refused, and the goal moves by its word alone.
/// - A host that is silent for 0.15 s has its goal held where the hand is; 0.5 s after its last
/// word
///   the hand lets go.
/// - During an emergency stop nothing is in hand and nothing is asked for.
/// - A goal that is no place is not gone to; the newest one said since the part was asked for is.
///
/// Time in which the controller is stopped counts for nobody.
class HostChecker {
 public:
  HostChecker(PeerId id, bool device_hand, Breakages& breakages)
      : id_(id), device_hand_(device_hand), breakages_(&breakages) {}

  // what reaches the controller
  void OnGoal(HostId host, const HostGoal& goal, std::int64_t now_ns);
  /// `refused`: the answer came at once, and is no.
  void OnRequest(HostId host, std::uint64_t number, const ControlRequest& request, bool refused,
                 std::int64_t now_ns);
  void OnAnswer(HostId host, std::uint64_t number, bool ok, std::int64_t now_ns);
  /// Somebody types it at the controller.
  void OnStop(bool stop, std::int64_t now_ns);
  /// It has stood still for so long, until now.
  void OnWoken(std::int64_t halted_ns, std::int64_t now_ns);

  /// After every frame. `way_m`: how far this hand has moved parts so far; `speed`: of the goal at
  /// the most.
  void Look(const HandSight& sight, double way_m, double speed);
  /// Whether a request waits for its answer.
  bool waits() const { return !waiting_.empty(); }

 private:
  struct Waiting {
    std::int64_t since_ns = 0;
    double most_s = 0;
    bool back = false;
  };
  struct Host {
    std::int64_t heard_ns = 0;
    std::uint32_t seq = 0;      // of its newest goal
    std::int64_t said_ns = 0;   // when
    std::optional<Pose> said;   // its newest goal
    std::int64_t moved_ns = 0;  // until when that may move the hand's goal; 0: it has said none
  };

  void Lose(HostId host, std::int64_t now_ns);
  void LookAtAnswers(const HandSight& sight, double way_m);
  void LookAtStop(const HandSight& sight);
  void LookAtSilence(const HandSight& sight, double speed);
  void LookAtGoal(const HandSight& sight);
  void LookAtNewestGoal(const HandSight& sight);
  bool MayMove(const HandSight& sight) const;
  double Silence(std::int64_t now_ns) const;

  PeerId id_;
  bool device_hand_;
  Breakages* breakages_;
  std::map<HostId, Host> hosts_;
  std::map<std::pair<HostId, std::uint64_t>, Waiting> waiting_;
  std::set<std::pair<HostId, std::uint64_t>> answered_;
  HostId owner_ = 0;             // whose the hand is
  std::int64_t owner_ns_ = 0;    // since when
  std::int64_t asked_ns_ = 0;    // when it last asked for something
  std::int64_t lost_ns_ = 0;     // when its last owner was lost; 0: the hand has let go since
  std::int64_t back_ns_ = 0;     // when a part last was on its way back
  std::int64_t stopped_ns_ = 0;  // since when an emergency stop holds; 0: none does
  std::int64_t woken_ns_ = 0;
  bool stop_ = false;
  std::int64_t held_ns_ = 0;     // since when something is in hand; 0: nothing is
  std::int64_t grasped_ns_ = 0;  // since when it is grasped
  std::optional<HandSight> before_;
};

}  // namespace tandem
