#pragma once

#include <string>
#include <vector>

#include "app/picture/picture.h"
#include "app/study/effect.h"
#include "app/study/results_table.h"
#include "app/study/study.h"

namespace tandem {

/// A measure by condition: each participant's means, joined by a line, and the mean over
/// participants with its confidence interval.
Picture PictureOf(const Study& study, const MeasureEffect& effect);

/// What a study has come to, as one page that asks nothing of any other file or host.
std::string StudyPage(const Study& study, const std::vector<ResultRow>& rows,
                      const std::vector<MeasureEffect>& effects, const std::string& mode);

}  // namespace tandem
