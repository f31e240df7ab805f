#pragma once

#include <span>

#include "collab/lab/metrics.h"

namespace tandem {

/// A figure in which a live run is put beside the same case in virtual time.
struct ComparedFigure {
  const char* name;
  double scale;  // from SI units to `unit`
  const char* unit;
  double Metrics::*value;
  double least;  // SI units; a smaller reference counts as this one
  bool judged;   // by the bar of `tandem stability live`
};

std::span<const ComparedFigure> ComparedFigures();

/// How far the live figure is from the virtual one, as a share of the virtual one or of the
/// figure's `least`. Infinite where either is no number.
double Off(const ComparedFigure& figure, const Metrics& live, const Metrics& virtual_time);

}  // namespace tandem
