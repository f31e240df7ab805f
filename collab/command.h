#pragma once

#include <cstdint>

#include "collab/messages.h"

namespace tandem {

/// What the user asks for, other than by moving the device. kStop, kResume: an emergency stop of the
/// device's force, and its end.
struct Command {
  enum class Kind : std::uint8_t { kGrab, kRelease, kGive, kHeal, kLayer, kDisplace, kStop, kResume };

  Kind kind = Kind::kGrab;
  ObjectId object = kNoObject;
  PeerId to = 0;           // kGive: whom to
  std::int32_t layer = 0;  // kLayer: the force layer of what is in hand
  double metres = 0;       // kDisplace: of its points, along their inward normals
};

}  // namespace tandem
