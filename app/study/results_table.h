#pragma once

#include <string>
#include <vector>

#include "app/study/study.h"
#include "app/study/trial_log.h"
#include "app/study/trial_order.h"

namespace tandem {

/// A trial, as results show it.
struct ResultRow {
  std::string participant;
  PlannedTrial plan;
  LoggedTrial logged;
};

/// Returns the trials of all participants who consented and did not withdraw, in the study's order.
std::vector<ResultRow> RowsOf(const Study& study, const TrialLog& log);

/// A column of results.csv, as the codebook describes it.
struct ResultColumn {
  std::string name;
  std::string kind;  // text, number, whole number, truth
  std::string unit;  // empty: none
  std::string about;
};

std::vector<ResultColumn> ColumnsOf(const Study& study);

/// Writes results.csv: a head, and a line for each trial. A cell without a value is empty.
std::string ResultsCsv(const Study& study, const std::vector<ResultRow>& rows);

/// Writes codebook.json: {"study", "title", "file", "row", "columns": [{"name", "kind", "unit",
/// "about"}]}.
std::string CodebookJson(const Study& study);
/// Writes codebook.md, the same for a reader.
std::string CodebookText(const Study& study);

/// Returns the gains that a condition sets, as "constant_stiffness=80"; empty: none.
std::string GainsText(const StudyCondition& condition);
/// Writes a number in the digits that restore it; empty: not finite.
std::string CsvNumber(double value);

}  // namespace tandem
