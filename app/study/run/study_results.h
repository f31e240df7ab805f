#pragma once

#include "app/study/run/study_session.h"
#include "app/study/study_file.h"
#include "app/study/trial_log.h"

namespace tandem {

/// Writes the tables, pictures and the report of a study into its folder, and prints them as JSON
/// where the request says so. Returns the exit code.
int WriteStudyResults(const StudyRequest& request, const Study& study, const TrialLog& log);

}  // namespace tandem
