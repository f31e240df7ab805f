#pragma once

#include <cstdint>

#include "collab/messages.h"

namespace tandem {

/// What the user asks for, other than by moving the device. kStop and kResume begin and end an
/// emergency stop of the hand. kScale is for a device that reaches the scene through a Workspace.
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
  PeerId to = 0;           // kGive: whom to
  std::int32_t layer = 0;  // kLayer: the force layer of what is in hand
  // kDisplace: of its points, along their inward normals; kScale: in the scene a metre of the
  // handle
  double metres = 0;
};

}  // namespace tandem
