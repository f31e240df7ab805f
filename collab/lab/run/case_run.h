#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "collab/lab/case/lab_case.h"
#include "collab/lab/case/lab_scene.h"
#include "collab/lab/metrics/metrics.h"

namespace tandem {

struct CaseResult {
  Metrics metrics;
  Verdict verdict = Verdict::kUndecided;
  std::uint64_t digest = 0;    // hash of every tenth frame's states and of the metrics
  double simulated_s = 0;      // length of the session, closing its loops included
  std::optional<Error> fault;  // why the case could not be run as it is, for example because its
                               // loops do not close
};

/// Takes every frame's measured state, for time series. `t_s` counts from when all loops are
/// closed.
using SeriesSink = std::function<void(double t_s, std::span<const UserFrame> users)>;

/// Says how long a run goes on when the case does not set its length.
struct RunLength {
  double most_s = 0;    // longest run; 0: four lengths of the case
  double rest_m_s = 0;  // the run goes on until it is stable with a slower tail; 0: while it decays
                        // and its tail is faster than a stable run's may be
};

/// Runs the product's peers in virtual time: one thread, no clock; the same case gives the same
/// bits. A run whose length the case does not set goes on, length by length, as `on` says. Then
/// `metrics` are those of the whole run. The case's schedule ends with the first length.
CaseResult RunCase(const LabCase& test, const LabScene& scene, const SeriesSink& series = {},
                   const RunLength& on = {});

}  // namespace tandem
