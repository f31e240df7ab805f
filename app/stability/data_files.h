#pragma once

#include <string>

#include "app/stability/report_data.h"

namespace tandem {

/// Where in a report's folder the case of a cell is, ready for `tandem stability run`.
std::string CaseFileOf(const std::string& sweep, const CellRecord& record);

/// Every figure of a sweep's cells as CSV, a line a cell.
std::string CsvOf(const Results& results);
/// A table as CSV.
std::string CsvOf(const ReportTable& table);
/// All of the report in one object: {"command", "version", "rows", "sweeps":
/// [{"header", "digest", "cells": [...]}], "tables", "series"}; cells as in a
/// results file.
std::string JsonOf(const ReportData& data);

}  // namespace tandem
