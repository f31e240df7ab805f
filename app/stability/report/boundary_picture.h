#pragma once

#include <string>
#include <vector>

#include "app/picture/picture.h"

namespace tandem {

/// A boundary found by `tandem stability boundary`.
struct BoundaryMark {
  std::string kind;     // all parameters but the delay; marks of one kind share a line
  double delay_s = 0;   // one-way
  double exact = 0;     // N/m, all links of a user; exact boundary
  double measured = 0;  // N/m; infinite: no boundary was found
};

/// Draws measured boundaries as dots and exact boundaries as lines, over the delay; both axes are
/// logarithmic.
Picture BoundaryPictureOf(const std::vector<BoundaryMark>& marks, const std::string& name);

}  // namespace tandem
