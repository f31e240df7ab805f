#pragma once

#include <cstdint>

#include "collab/session/messages.h"

namespace tandem {

/// An order of the user, apart from moving the device. kStop and kResume begin and end an emergency
/// stop of the hand. kScale is for a device that reaches the scene through a Workspace.
struct Command {
  enum class Kind : std::uint8_t {
    kGrab,
    kRelease,
    kGive,
    kHeal,
    kLayer,
    kDisplace,
    kStop,
    kResume,
    kScale
  };

  Kind kind = Kind::kGrab;
  ObjectId object = kNoObject;
  PeerId to = 0;           // kGive: the receiver
  std::int32_t layer = 0;  // kLayer: the force layer of the body in hand
  // kDisplace: displacement of its points along their inward normals; kScale: metres of the scene
  // per metre of the handle
  double metres = 0;
};

}  // namespace tandem
