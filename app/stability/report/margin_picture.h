#pragma once

#include "app/picture/picture.h"
#include "collab/lab/sweep/results_file.h"

namespace tandem {

/// Draws all cells that have a prediction: the ratio of stiffness to boundary from left to right,
/// growth upwards, marks by verdict. Cells predicted stable that are not stable stand to the left,
/// above zero.
Picture MarginPictureOf(const Results& results, const std::string& name);

}  // namespace tandem
