#pragma once

#include <string>

#include "app/stability/report/report_data.h"

namespace tandem {

/// Returns the place in a report's folder of a cell's case, ready for `tandem stability run`.
std::string CaseFileOf(const std::string& sweep, const CellRecord& record);

/// Writes all figures of a sweep's cells as CSV, one cell a line.
std::string CsvOf(const Results& results);
/// Writes a table as CSV.
std::string CsvOf(const ReportTable& table);
/// Writes the whole report as one object: {"command", "version", "rows", "sweeps": [{"header",
/// "digest", "cells": [...]}], "tables", "series"}. Cells are as in a results file.
std::string JsonOf(const ReportData& data);

}  // namespace tandem
