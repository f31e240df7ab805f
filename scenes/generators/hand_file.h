#pragma once

#include <string>

#include "engine/haptics/hand_script.h"

namespace tandem {

/// Returns the text that LoadHandScript() reads as that script: its lengths to a micrometre, its
/// rotations to a microradian.
std::string HandFile(const HandScript& script);

}  // namespace tandem
