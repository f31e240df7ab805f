#pragma once

#include <memory>
#include <vector>

#include "collab/simulated/network/simulated_session.h"
#include "engine/haptics/hand_script.h"
#include "engine/scene/scene.h"

namespace tandem::testing {

struct SimulatedDemo {
  std::shared_ptr<const WorldModel> model;
  std::vector<std::vector<TraceSample>> traces;  // one a hand
  std::vector<double> mean_delay_s;
};

struct SimulatedDemoOptions {
  double seconds = 20;
  LinkConditions conditions{.delay_ms = 100};
  std::shared_ptr<const CouplingLaw> law = DefaultLaw();
  bool contact = true;
  /// Time by which the second hand begins after the first; below 0: before it.
  double second_begins_later_s = 0;
};

/// Returns the scene of that name among the generated ones.
Result<Scene> GeneratedScene(const std::string& name);

/// Does what `tandem demo` does with a scene, in virtual time: a whole peer for each of its hands.
Result<SimulatedDemo> RunSimulatedDemo(const std::string& scene,
                                       const SimulatedDemoOptions& options);

/// Returns a whole peer that holds one body of a loaded scene by a script.
std::unique_ptr<PeerNode> MakeNode(const std::shared_ptr<const WorldModel>& model, PeerId id,
                                   int object, const HandScript& script, NodeOptions options);

}  // namespace tandem::testing
