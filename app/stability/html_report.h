#pragma once

#include <string>

#include "app/stability/report_data.h"

namespace tandem {

/// The report as one page that asks nothing of any other file or host. All is
/// there without script; with it tables sort by a click on their heads, and
/// what one points at in a picture is told at the foot of the page.
std::string HtmlOf(const ReportData& data);

}  // namespace tandem
