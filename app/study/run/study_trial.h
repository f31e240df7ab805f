#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/process/child_processes.h"
#include "app/study/interview.h"
#include "app/study/study.h"
#include "app/study/trial_meter.h"
#include "app/study/trial_order.h"
#include "collab/lab/case/lab_case.h"
#include "collab/lab/case/lab_scene.h"
#include "engine/base/result.h"

namespace tandem {

/// The settings by which trials run at this site.
struct TrialSetup {
  bool persons = true;        // else modelled hands
  bool real_peers = true;     // else virtual time, for modelled hands alone
  bool partner_site = false;  // this machine has the partner's peer, not the participant's
  std::string device;         // device of the person here, NAME:OPTIONS; empty: the window
  std::vector<std::string> connection;  // options by which peers reach a partner at another site
  double wait_seconds = 60;             // time to wait for the partner
};

struct TrialOfParticipant {
  int participant = 0;  // counted from 0
  std::string pseudonym;
  PlannedTrial plan;
};

/// Runs a study's trials, one at a time.
class TrialRunner {
 public:
  /// `study` must outlive this object.
  TrialRunner(const Study& study, TrialSetup setup);

  /// Loads the scenes of all trials, so that the program tells of their faults before anybody
  /// consents.
  std::optional<Error> LoadScenes();
  /// Runs a trial and measures it. `folder` is there and empty. In it the trial leaves case.json,
  /// hand files and, in virtual time, series.csv. Real peers leave their plans, recordings,
  /// reports, what they said, and trial.mcap. Errors: something else than the person cut the trial
  /// short.
  Result<TrialMeasures> Run(const TrialOfParticipant& trial, const std::filesystem::path& folder,
                            Interview& interview);

 private:
  /// The peers of a trial, as they are started.
  struct TrialPeers {
    const LabCase& test;  // fitted to the scene's body
    const LabScene& scene;
    std::filesystem::path folder;
    std::string session;
    std::string control;   // name of the controller that a window attaches to
    std::size_t own = 0;   // user at this site
    bool all_here = true;  // both users have their peers on this machine
    double seconds = 0;
  };

  std::vector<std::string> CommandLineOfUser(const TrialPeers& peers, std::size_t user) const;
  Result<std::vector<ChildProcess>> StartPeers(const TrialPeers& peers) const;
  const std::string& SceneNameOf(const PlannedTrial& plan) const;
  Result<const LabScene*> SceneOf(const PlannedTrial& plan);
  TrialMeter MeterOf(const PlannedTrial& plan, const LabScene& scene) const;
  Result<TrialMeasures> RunVirtual(const PlannedTrial& plan, const LabCase& test,
                                   const LabScene& scene, const std::filesystem::path& folder);
  Result<TrialMeasures> RunReal(const TrialOfParticipant& trial, const LabCase& test,
                                const LabScene& scene, const std::filesystem::path& folder,
                                Interview& interview);
  Result<TrialMeasures> Measure(const PlannedTrial& plan, const LabScene& scene,
                                const std::filesystem::path& folder) const;

  const Study& study_;
  TrialSetup setup_;
  std::map<std::string, LabScene> scenes_;  // key is scene and body
};

}  // namespace tandem
