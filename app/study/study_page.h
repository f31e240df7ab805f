#pragma once

#include <string>
#include <vector>

#include "app/picture/picture.h"
#include "app/study/effect.h"
#include "app/study/results_table.h"
#include "app/study/study.h"

namespace tandem {

/// Draws a measure by condition: each participant's means, joined by a line, and the mean over
/// participants with its confidence interval.
Picture PictureOf(const Study& study, const MeasureEffect& effect);

/// Writes a study's results as one page that loads no other file and contacts no host.
std::string StudyPage(const Study& study, const std::vector<ResultRow>& rows,
                      const std::vector<MeasureEffect>& effects, const std::string& mode);

}  // namespace tandem
