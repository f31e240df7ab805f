#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "collab/controller/control_server.h"
#include "collab/simulated/hands/checkers/goal_hand_checker.h"

namespace tandem {

/// Judges where parts are when a way back is over. A granted request to go back must bring its part
/// to within 10 mm of where the hand took it. Its part is the one in hand, the last one, or each
/// that this hand has moved. The hand's last pose of the part counts, because others may hold it
/// too. The checker knows only what it saw when parts were taken. It does not judge ways of more
/// than 12 m, which a controller need not remember.
class ReturnChecker {
 public:
  static constexpr double kNear = 0.01;     // m
  static constexpr double kMostWay = 12.0;  // m

  ReturnChecker(PeerId id, Violations& violations) : id_(id), violations_(&violations) {}

  void OnRequest(HostId host, std::uint64_t number, const RetraceRequest& request) {
    requested_[{host, number}] = request.to;
  }
  void OnAnswer(HostId host, std::uint64_t number, const Answer& answer);
  /// Judges a frame; call it after every frame. `order` is the newest order to the hand. An
  /// order to take a part that keeps its way is for the first part that comes.
  void Check(const HandObservation& sight, const GoalOrder& order);
  /// Returns how far this hand has moved parts, m.
  double way_m() const { return way_m_; }

 private:
  struct Taken {
    int body = -1;
    Pose X_WB;
    double way_m = 0;  // the hand's way when it took the part
  };

  void CheckPlace(const Taken& taken);

  PeerId id_;
  Violations* violations_;
  std::map<std::pair<HostId, std::uint64_t>, RetraceRequest::To> requested_;
  std::vector<Taken> taken_;  // the newest last
  bool all_known_ = true;     // taken_ has all parts that the controller remembers
  double way_m_ = 0;
  std::uint32_t taken_seq_ = 0;  // order by which the last part came
  int held_ = -1;
  std::map<int, Pose> held_at_;  // pose in which the hand last had each body
};

}  // namespace tandem
