#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tandem {

/// The options of `tandem study`.
struct StudyRequest {
  std::filesystem::path file;
  std::filesystem::path folder;  // folder of all that is kept
  bool dry_run = false;          // modelled hands in place of persons
  bool real_time = false;        // real peers in place of virtual time, in a dry run
  bool partner_site = false;
  bool results_only = false;
  bool json = false;
  int from_trial = 1;       // first trial, at the partner's site
  std::string participant;  // pseudonym; empty: the next participant
  std::string withdraw;     // pseudonym whose data are removed
  std::string device;       // NAME:OPTIONS; empty: the window
  std::string version;      // version of the program
  std::vector<std::string> connection;
  double wait_seconds = 60;
};

/// Runs trials of a study, or only writes its results. Returns the exit code.
int RunStudy(const StudyRequest& request);

}  // namespace tandem
