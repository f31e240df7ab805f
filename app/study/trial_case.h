#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/study/study.h"
#include "app/study/trial_order.h"
#include "collab/lab/case/lab_case.h"
#include "collab/lab/case/lab_scene.h"
#include "engine/base/result.h"

namespace tandem {

/// The scene and the folder of a trial's case, on this machine.
struct TrialPlace {
  std::string scene;             // one of the lab's scenes, or a file
  std::filesystem::path folder;  // trial's folder
};

/// Makes a trial's case for the stability lab. User 0 is the participant, user 1 the partner.
///
/// A modelled hand has a pace, a factor on all times of its script. The study's seed draws one
/// factor for the participant (8 % standard deviation) and one for the trial (3 %). The pace is
/// their product times the condition's `planted_slower`. Both hands of a trial have the same pace.
///
/// Writes `case.json`, `user-0.hand.json` and `user-1.hand.json` into the folder, and returns the
/// case as that file has it. `tandem stability run case.json` repeats it.
Result<LabCase> MakeTrialCase(const Study& study, int participant, const PlannedTrial& trial,
                              const LabScene& scene, const TrialPlace& place);

/// Returns the factor on the times of the trial's modelled hands.
double PaceOf(const Study& study, int participant, const PlannedTrial& trial);

/// Returns the answer of a modelled person, drawn by the study's seed.
std::string ModelledAnswer(const Study& study, int participant, const PlannedTrial& trial,
                           const StudyQuestion& question);

}  // namespace tandem
