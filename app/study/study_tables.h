#pragma once

#include <string>
#include <vector>

#include "app/study/effect.h"
#include "app/study/results_table.h"
#include "app/study/study.h"

namespace tandem {

/// Formats a number in four digits; empty: not finite.
std::string PageFigure(double value);
/// Formats an interval as "LOW to HIGH"; empty: no interval.
std::string PageInterval(const MeanInterval& interval);

/// Returns whether all participants have the same value in all conditions, so that a picture would
/// show nothing.
bool AllTheSame(const MeasureEffect& effect);

/// Makes a table of all conditions with the values that they set.
std::string ConditionsTable(const Study& study);
/// Makes a table with a row for each measure and condition: mean, difference from the reference,
/// its interval and effect size. A difference whose interval excludes zero is marked.
std::string SummaryTable(const Study& study, const std::vector<MeasureEffect>& effects);
/// Makes a table for each question of the kind choice: how often each choice was taken in each
/// condition. Empty: the study has no such question.
std::string ChoicesTable(const Study& study, const std::vector<ResultRow>& rows);
/// Makes a table of all trials with their measures. A trial that has run is linked to its case.
std::string TrialsTable(const Study& study, const std::vector<ResultRow>& rows);

}  // namespace tandem
