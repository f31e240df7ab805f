#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "app/stability/report/report_data.h"

namespace tandem {

/// Makes a table with a row for each case that a sweep ran with several seeds. A row has the number
/// of stable runs, and the least, median and greatest growth and divergence. Nothing: the sweep
/// repeats no case.
std::optional<ReportTable> SeedSpreadOf(const Results& results);

/// Counts the cases of a clean network that a sweep ran with several seeds, and that have the same
/// figures with each of them: nothing is random there.
std::size_t CountCasesAlikeForAllSeeds(const Results& results);

}  // namespace tandem
