#pragma once

#include <optional>
#include <string>

#include "app/stability/report_data.h"

namespace tandem {

/// A table with a row for each case that a sweep ran with several seeds: how many runs were stable,
/// and the least, the median and the greatest of growth and divergence. Nothing where the sweep
/// repeats no case.
std::optional<ReportTable> SeedSpreadOf(const Results& results);

}  // namespace tandem
