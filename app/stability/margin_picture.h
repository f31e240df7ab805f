#pragma once

#include "app/picture/picture.h"
#include "collab/lab/results_file.h"

namespace tandem {

/// All cells for which there is a prediction: stiffness over the boundary's
/// from left to right, growth upwards, marks for what was measured. What was
/// predicted stable, and is not, stands in the left part above zero.
Picture MarginPictureOf(const Results& results, const std::string& name);

}  // namespace tandem
