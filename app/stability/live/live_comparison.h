#pragma once

#include <span>

#include "collab/lab/metrics/metrics.h"

namespace tandem {

/// A figure by which a live run is compared with the same case in virtual time.
struct ComparedFigure {
  const char* name;
  double scale;  // from SI units to `unit`
  const char* unit;
  double Metrics::*value;
  double least;  // SI units; a smaller reference counts as this one
  bool judged;   // the bar of `tandem stability live` applies to it
};

std::span<const ComparedFigure> ComparedFigures();

/// Returns the signed difference of the live figure from the virtual one, as a share of the larger
/// of the virtual one and the figure's `least`. Infinite if either is no number.
double DeviationOf(const ComparedFigure& figure, const Metrics& live, const Metrics& virtual_time);

}  // namespace tandem
