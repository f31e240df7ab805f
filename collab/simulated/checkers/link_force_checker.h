#pragma once

#include <map>
#include <utility>

#include "collab/simulated/checkers/violations.h"
#include "collab/simulated/network/simulated_session.h"

namespace tandem {

/// Judges which way links pull. Over a session it sums a link's force times the way to the true
/// place of the other instance. The sum must be at least half of what it would be if the two were
/// always parallel. The same holds for moment and turn. A link that pushes or turns instances apart
/// may rest as quietly, held by the hands, and give no energy. Only short loops are judged, where
/// the copy is near the true instance, and only frames in which the instances do not approach:
/// while they do, the link's damper rightly holds against its spring.
class LinkForceChecker {
 public:
  static constexpr double kShortLoop = 0.2;  // s
  // J s; links with less are not judged
  static constexpr double kEnough = 2e-3;
  static constexpr double kEnoughTurned = 0.2e-3;
  static constexpr double kMostTurn =
      2.5;  // rad between instances: near half a turn it has no side
  // share of the sum for parallel vectors
  static constexpr double kLeastTogether = 0.5;

  /// `short_loop` bounds the loops that are judged, because instances move on during longer ones.
  explicit LinkForceChecker(Violations& violations, double short_loop = kShortLoop)
      : violations_(&violations), short_loop_(short_loop) {}

  /// Judges a frame; call it after every frame.
  void Check(SimulatedSession& session);
  void CheckEnd();

 private:
  struct Pull {
    double together = 0;  // J s, force along the way
    double all = 0;
    double turned = 0;  // moment along the turn
    double all_turned = 0;
  };

  Violations* violations_;
  double short_loop_;
  std::map<std::pair<PeerId, PeerId>, Pull> pulls_;  // keys: the pulled peer, the peer whose copy
                                                     // pulls
};

}  // namespace tandem
