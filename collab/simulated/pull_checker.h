#pragma once

#include <map>
#include <utility>

#include "collab/simulated/breakages.h"
#include "collab/simulated/simulated_session.h"

namespace tandem {

/// Which way links pull. Over a session the force of a link, times the way to where the other
/// instance truly is, does not sum up to much less than nothing; nor do its moment and the turn. A
/// link that pushes or turns instances apart may rest as quietly, held by the hands, and give no
/// energy. Where the loop is short, so that the copy is where the instance is.
class PullChecker {
 public:
  static constexpr double kShortLoop = 0.2;  // s
  static constexpr double kEnough = 0.2e-3;  // J s, for a judgement
  static constexpr double kApart = 0.3;      // of all, to count

  explicit PullChecker(Breakages& breakages) : breakages_(&breakages) {}

  /// After every frame.
  void Look(SimulatedSession& session);
  void LookAtEnd();

 private:
  struct Pull {
    double together = 0;  // J s, of the force
    double all = 0;
    double turned = 0;  // of the moment
    double all_turned = 0;
  };

  Breakages* breakages_;
  std::map<std::pair<PeerId, PeerId>, Pull> pulls_;  // of the first, by the copy of the second
};

}  // namespace tandem
