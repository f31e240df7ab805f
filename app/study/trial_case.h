#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/study/study.h"
#include "app/study/trial_order.h"
#include "collab/lab/lab_case.h"
#include "collab/lab/lab_scene.h"
#include "engine/base/result.h"

namespace tandem {

/// Where a trial's case is made: what the study's names stand for on this machine.
struct TrialPlace {
  std::string scene;             // one of the lab's own, or a file
  std::filesystem::path folder;  // of the trial
};

/// A trial as a case of the stability lab, two users: the participant, then the partner.
///
/// A modelled hand has a pace: all times of its script are multiplied by a factor that the study's
/// seed draws for the participant (8 % standard deviation) and for the trial (3 %), and by the
/// condition's `planted_slower`. Both hands of a trial have one pace.
///
/// Writes `case.json`, `user-0.hand.json` and `user-1.hand.json` into the folder, and gives back
/// the case as it stands in that file: `tandem stability run case.json` repeats it.
Result<LabCase> MakeTrialCase(const Study& study, int participant, const PlannedTrial& trial,
                              const LabScene& scene, const TrialPlace& place);

/// The factor of the times of that trial's modelled hands.
double PaceOf(const Study& study, int participant, const PlannedTrial& trial);

/// What a modelled person answers, drawn by the study's seed.
std::string ModelledAnswer(const Study& study, int participant, const PlannedTrial& trial,
                           const StudyQuestion& question);

}  // namespace tandem
