#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "collab/session/messages.h"
#include "engine/contact/pair/clearance.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The simulated scene, as a controller's server knows it.
struct ControlScene {
  struct Body {
    std::string name;
    bool fixed = false;
    bool shared = false;
    int moving = -1;              // number of its moving body: itself, or the body it is part of
    ObjectId object = kNoObject;  // scene object of that moving body
    double radius = 0;  // greatest distance of that moving body's points from its centre, m
    Pose X_WB0{};       // initial pose of that moving body; of a fixed body its file's frame
  };

  std::uint64_t number = 0;  // counts loads
  std::string session;
  std::string file;
  PeerId self = 0;
  bool own_only = false;  // takes no shared body in hand
  std::vector<Body> bodies;
  ClearanceBounds clearance;
  std::vector<std::string> warnings{};  // facts on the scene for its user, from the start

  /// Returns the index of the body of that name; -1: none.
  int BodyNamed(const std::string& name) const;
  /// Returns the scene body with that number among the moving ones; -1: none.
  int BodyOfMoving(int moving) const;
};

ControlScene ControlSceneOf(const WorldModel& model);

}  // namespace tandem
