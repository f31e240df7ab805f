#pragma once

#include <cstdint>

#include "collab/messages.h"

namespace tandem {

/// What the user asks for, other than by moving the device.
struct Command {
  enum class Kind : std::uint8_t { kGrab, kRelease, kGive, kHeal };

  Kind kind = Kind::kGrab;
  ObjectId object = kNoObject;
  PeerId to = 0;  // kGive: whom to
};

}  // namespace tandem
