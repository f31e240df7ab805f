#pragma once

#include <optional>

#include "collab/lab/case_run.h"

namespace tandem {

/// Where motion begins to grow as a case's links become firmer; N/m, all links of a user together.
struct BoundaryPoint {
  double predicted = 0;
  double measured = 0;  // infinite: none up to the most that was tried
  double onset_hz = 0;  // predicted, of what grows there
  int runs = 0;
  std::optional<Error> fault;  // a case that cannot be run, or of which theory says nothing

  double ratio() const { return measured / predicted; }
};

/// Runs the case with more and less stiffness, all drags as they are for `law.ratio` 1, and halves
/// the distance between what dies out and what grows until they are half a per cent apart. By the
/// sign of the growth, not by the verdict: beside the boundary growth is slow. `most`: how far
/// above the predicted boundary to look. Deterministic, as RunCase() is.
BoundaryPoint FindBoundary(LabCase test, const LabScene& scene, double most = 4);

}  // namespace tandem
