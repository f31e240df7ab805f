#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "collab/messages.h"
#include "engine/contact/clearance.h"
#include "engine/world/world_model.h"

namespace tandem {

/// What a controller's server knows of the scene that is simulated.
struct ControlScene {
  struct Body {
    std::string name;
    bool fixed = false;
    bool shared = false;
    int moving = -1;  // its number among the moving ones, or of the one that it is a part of
    ObjectId object = kNoObject;  // of that one
    Pose X_WB0{};                 // first pose of that one; of a fixed body its file's frame
  };

  std::uint64_t number = 0;  // counts loads
  std::string session;
  std::string file;
  PeerId self = 0;
  bool own_only = false;  // shared bodies are not held
  std::vector<Body> bodies;
  ClearanceBounds clearance;

  /// Index of the body of that name, or -1.
  int BodyNamed(const std::string& name) const;
  /// The first scene body that is this moving one; -1: none.
  int BodyOfMoving(int moving) const;
};

ControlScene ControlSceneOf(const WorldModel& model);

}  // namespace tandem
