#pragma once

#include "collab/session/planted_faults.h"

namespace tandem {

/// Returns whether the present session has this fault.
inline bool Injected(Fault fault) noexcept {
  return Planted(fault);
}

}  // namespace tandem
