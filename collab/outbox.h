#pragma once

#include "collab/messages.h"

namespace tandem {

/// What a haptic frame has to say; the sender thread takes the newest.
struct Outbox {
  bool holds = false;  // a body: without one there is nothing to say
  ObjectState state;
  bool shared = false;  // links go with the state
  CouplingLinks links;
  ViewFrame view;
};

}  // namespace tandem
