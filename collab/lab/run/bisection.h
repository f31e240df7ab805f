#pragma once

#include <optional>

#include "collab/lab/run/case_run.h"

namespace tandem {

/// The stiffness at which motion begins to grow, in N/m, all links of a user together.
struct BoundaryPoint {
  double predicted = 0;
  double measured = 0;  // infinite: no growth up to the highest stiffness tried
  double onset_hz = 0;  // predicted frequency of the growing motion
  int runs = 0;
  std::optional<Error> fault;  // the case cannot be run, or theory says nothing of it

  double ratio() const { return measured / predicted; }
};

/// Runs the case with more and less stiffness, and bisects between decay and growth until the two
/// ends are half a per cent apart. All drags stay as they are for `law.ratio` 1. The sign of the
/// growth decides, not the verdict, because growth beside the boundary is slow. The search ends at
/// `most` times the predicted boundary. The result is deterministic, as that of RunCase() is.
BoundaryPoint FindBoundary(LabCase test, const LabScene& scene, double most = 4);

}  // namespace tandem
