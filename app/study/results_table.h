#pragma once

#include <string>
#include <vector>

#include "app/study/study.h"
#include "app/study/trial_log.h"
#include "app/study/trial_order.h"

namespace tandem {

/// A trial as results have it.
struct ResultRow {
  std::string participant;
  PlannedTrial plan;
  LoggedTrial logged;
};

/// The trials of all who consented and did not withdraw, in the order of the study.
std::vector<ResultRow> RowsOf(const Study& study, const TrialLog& log);

/// A column of results.csv, as the codebook describes it.
struct ResultColumn {
  std::string name;
  std::string kind;  // text, number, whole number, truth
  std::string unit;  // empty: none
  std::string about;
};

std::vector<ResultColumn> ColumnsOf(const Study& study);

/// results.csv: a head and a line for each trial. A cell without a value is empty.
std::string ResultsCsv(const Study& study, const std::vector<ResultRow>& rows);

/// codebook.json: {"study", "title", "file", "row", "columns": [{"name", "kind", "unit",
/// "about"}]}.
std::string CodebookJson(const Study& study);
/// codebook.md: the same for a reader.
std::string CodebookText(const Study& study);

/// The gains that a condition sets, as "constant_stiffness=80"; empty: none.
std::string GainsText(const StudyCondition& condition);
/// A number with the digits that give it back, or nothing for what is none.
std::string CsvNumber(double value);

}  // namespace tandem
