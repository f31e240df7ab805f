#pragma once

#include <string>
#include <vector>

#include "app/study/effect.h"
#include "app/study/results_table.h"
#include "app/study/study.h"

namespace tandem {

/// To four digits; empty: no number.
std::string PageFigure(double value);
/// "LOW to HIGH"; empty: no interval.
std::string PageInterval(const MeanInterval& interval);

/// Returns whether all participants have the same value in all conditions, so that a picture would
/// show nothing.
bool AllTheSame(const MeasureEffect& effect);

/// All conditions with what they set.
std::string ConditionsTable(const Study& study);
/// A row for each measure and condition: mean, difference from the reference, its interval and
/// effect size. A difference whose interval leaves out zero is marked.
std::string SummaryTable(const Study& study, const std::vector<MeasureEffect>& effects);
/// How often each choice was taken in each condition, for questions of the kind choice; empty: the
/// study has none.
std::string ChoicesTable(const Study& study, const std::vector<ResultRow>& rows);
/// All trials with their measures, each linked to its case where it has run.
std::string TrialsTable(const Study& study, const std::vector<ResultRow>& rows);

}  // namespace tandem
