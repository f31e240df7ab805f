#pragma once

#include <map>
#include <utility>
#include <vector>

#include "collab/simulated/breakages.h"
#include "collab/simulated/simulated_session.h"

namespace tandem {

/// What each link gives to the two instances that it couples, against what it may: the credits of
/// its two ends and nine tenths of its share of what drag has taken out. From the wrenches as
/// applied and the motion, not from the ends' own books.
///
///   W_ij: J that the pull of j's copy did on i's instance;  D_ij: of the drag on i's instance, by
///   stiffness;  W_ij + W_ji - 0.9 (D_ij + D_ji) <= credits
///
/// A link that begins anew, after one of its ends has let go or was given up, has new credit there.
class EnergyChecker {
 public:
  static constexpr double kCredit = 0.1;      // J of one end, as docs/decisions/0017 gives it
  static constexpr double kMostKept = 1.5;    // J, in the tanks, the springs and on the way
  static constexpr double kTolerance = 0.02;  // J, for work by the velocity at a frame's end

  /// `kept`: J, in place of kMostKept.
  EnergyChecker(const WorldModel& model, Breakages& breakages, double kept = kMostKept)
      : model_(&model), breakages_(&breakages), kept_(kept) {}

  /// After every frame.
  void Look(SimulatedSession& session);

 private:
  struct Link {
    double made = 0;    // J
    double credit = 0;  // J
  };

  void LookAt(SimulatedSession& session, std::size_t member);

  const WorldModel* model_;
  Breakages* breakages_;
  double kept_;
  std::map<std::pair<PeerId, PeerId>, Link> links_;
  std::vector<std::vector<PeerId>> partners_;  // of each member, a frame ago
};

}  // namespace tandem
