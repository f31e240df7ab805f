#pragma once

#include <map>
#include <utility>
#include <vector>

#include "collab/simulated/checkers/violations.h"
#include "collab/simulated/network/simulated_session.h"

namespace tandem {

/// Judges the energy that each link gives to the two instances that it couples. It may be at most
/// the credits of both ends and nine tenths of the link's share of the energy that drag took. The
/// checker uses the wrenches as applied and the motion, not the ends' own accounts.
///
/// W_ij is the work (J) of the pull of j's copy on i's instance. D_ij is the link's share, by
/// stiffness, of the drag's work on i's instance:
///
///   W_ij + W_ji - 0.9 (D_ij + D_ji) <= credits
///
/// A link that begins anew, after one of its ends has let go or was given up, has new credit there.
class EnergyChecker {
 public:
  static constexpr double kCredit = 0.1;      // J, for one end (docs/decisions/0017)
  static constexpr double kMostKept = 1.5;    // J, kept in the tanks, in the springs and on the way
  static constexpr double kTolerance = 0.02;  // J, for the error of taking a frame's final velocity

  /// `kept` replaces kMostKept, J.
  EnergyChecker(const WorldModel& model, Violations& violations, double kept = kMostKept)
      : model_(&model), violations_(&violations), kept_(kept) {}

  /// Judges a frame; call it after every frame.
  void Check(SimulatedSession& session);

 private:
  struct Link {
    double made = 0;    // J
    double credit = 0;  // J
  };

  void CheckMember(SimulatedSession& session, std::size_t member);

  const WorldModel* model_;
  Violations* violations_;
  double kept_;
  std::map<std::pair<PeerId, PeerId>, Link> links_;
  std::vector<std::vector<PeerId>> coupled_peers_;  // indexed by member, a frame ago
};

}  // namespace tandem
