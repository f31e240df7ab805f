#pragma once

#include <cstdint>
#include <vector>

#include "collab/controller/control_scene.h"
#include "collab/controller/simulation_facts.h"

namespace tandem {

/// The ways of all moving bodies from their first places to where they are, whoever moved them, as
/// this controller has seen them. A way has a pose for each millimetre of travel, and no loops: a
/// body that comes back to a pose of its way is where the rest of the way is forgotten. A long way
/// is kept with fewer poses.
class BodyTrails {
 public:
  static constexpr double kStep = 1e-3;       // travel from one pose to the next, m
  static constexpr std::size_t kMost = 1024;  // poses of a body

  /// Notes where the bodies are. Another scene begins the ways anew.
  void See(const SimulationFacts& facts, const ControlScene& scene);

  /// Returns the numbers of the moving bodies that are not at their first places, the body that
  /// moved last first.
  std::vector<int> Displaced() const;
  /// Returns the way of a moving body: its first place, and on to where it was seen last.
  const std::vector<Pose>& way(int moving) const {
    return trails_[static_cast<std::size_t>(moving)].poses;
  }
  /// Returns the travel of that body between two poses, m.
  double Travel(int moving, const Pose& from, const Pose& to) const;

 private:
  struct Trail {
    double radius = 0;
    std::uint64_t moved = 0;  // time of its last step, counted in steps of all bodies
    std::vector<Pose> poses;
  };
  void Note(Trail& trail, const Pose& X_WB);

  std::uint64_t scene_number_ = 0;
  std::uint64_t steps_ = 0;
  std::vector<Trail> trails_;
};

}  // namespace tandem
