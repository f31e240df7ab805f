#pragma once

#include <string>

#include "engine/haptics/hand_script.h"

namespace tandem {

/// What LoadHandScript() reads as that script: its lengths to a micrometre, its turns to a
/// microradian.
std::string HandFile(const HandScript& script);

}  // namespace tandem
