#pragma once

#include "collab/session/messages.h"

namespace tandem {

/// Another user's instance of a shared body, where last heard.
struct InstanceView {
  PeerId peer = 0;
  Pose X_WB;
};

/// Figures of a link, shown and logged.
struct LinkView {
  PeerId peer = 0;
  bool closed = false;      // the peer holds the body, and the loop to it is closed
  double loop_age_s = 0;    // present loop age
  double te_s = 0;          // delay that the law gets for it
  double stiffness = 0;     // N/m in use
  double force = 0;         // N; on our instance
  double its_force = 0;     // N; on its instance, as it says
  double tank = 0;          // J; tank of our gate
  bool clipped = false;     // the gate holds the copy back
  double disagreement = 0;  // |own + its| / the larger, of the link's two wrenches; 0 at rest
};

}  // namespace tandem
