#pragma once

#include <string>

#include "app/stability/report/report_data.h"

namespace tandem {

/// Writes the report as one page that loads no other file and contacts no host. All content is
/// there without a script. With it, a click on a table's head sorts the table, and the foot of the
/// page describes the shape below the pointer.
std::string HtmlOf(const ReportData& data);

}  // namespace tandem
