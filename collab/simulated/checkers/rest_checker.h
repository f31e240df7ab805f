#pragma once

#include <vector>

#include "collab/session/viewer.h"
#include "collab/simulated/checkers/hand_checker.h"
#include "collab/simulated/checkers/violations.h"
#include "collab/simulated/checkers/wire_checker.h"
#include "collab/simulated/network/simulated_session.h"

namespace tandem {

/// Judges a session once the faults are over, the hands rest and enough time has passed. All peers
/// know which peers are here. All copies of every body agree, also of bodies that nobody holds. No
/// hand is pulled, and all holders of a body are linked as the law says.
class RestChecker {
 public:
  static constexpr double kMostForce = 0.5;  // N
  static constexpr double kDistance = 1e-3;  // m, between copies
  static constexpr double kAngle = 0.5 * 3.141592653589793 / 180;

  RestChecker(const FaultSchedule& schedule, const WorldModel& model, Violations& violations)
      : schedule_(&schedule), model_(&model), violations_(&violations) {}

  /// `member` is the number in the session of each scheduled peer; -1: it never came.
  void Check(SimulatedSession& session, const std::vector<int>& member, const HandChecker& hands,
             const Viewer& viewer);
  /// Judges the links; call it later, when the longest silence is forgotten.
  void CheckLinks(SimulatedSession& session, WireChecker& wire);

 private:
  void CheckMembership(SimulatedSession& session, const std::vector<std::size_t>& present,
                       const Viewer& viewer);
  void CheckCopies(SimulatedSession& session, const std::vector<std::size_t>& present);
  void CheckLinksOf(SimulatedSession& session, std::size_t member,
                    const std::vector<std::size_t>& holders, WireChecker& wire);

  const FaultSchedule* schedule_;
  const WorldModel* model_;
  Violations* violations_;
};

}  // namespace tandem
