#pragma once

#include <string>
#include <vector>

#include "app/picture/picture.h"

namespace tandem {

/// A boundary that `tandem stability boundary` found.
struct BoundaryMark {
  std::string kind;     // all but the delay: marks of one kind are on one line
  double delay_s = 0;   // one way
  double exact = 0;     // N/m, all links of a user
  double measured = 0;  // N/m; infinite: none was found
};

/// Measured boundaries as dots on lines of the exact ones, over the delay; both axes logarithmic.
Picture BoundaryPictureOf(const std::vector<BoundaryMark>& marks, const std::string& name);

}  // namespace tandem
