#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/network/running_program.h"
#include "tests/soak/program_log.h"
#include "tests/soak/soak_schedule.h"

namespace tandem::testing {

/// A count by the kernel for a program at one time.
struct Footprint {
  double at_s = 0;
  std::int64_t memory = 0;  // bytes that are resident
  std::size_t files = 0;    // open descriptors
};

/// The remains of one life of a program of the session, from its start to its end.
struct SoakLife {
  std::size_t place = 0;
  std::string name{};
  double began_s = 0;
  double ended_s = 0;
  bool killed = false;
  bool disk_full = false;    // the recording could not be finished
  double stopped_s = 0;      // time stopped by SIGSTOP, in all
  double took_to_end_s = 0;  // from SIGTERM to the end
  std::optional<int> exit_code{};
  std::optional<bool> said_goodbye{};  // and was heard; nothing: there was no witness
  std::vector<Footprint> footprints{};
  double most_lines_per_s = 0;
  std::size_t lines = 0;
  std::size_t losses = 0;    // number of other programs lost
  std::string not_finite{};  // line with a number that is none
  std::filesystem::path report{};

  bool is_peer() const { return place < SoakPlaces::kPeers; }
};

/// A peer or viewer of the product that runs beside the test, with what the test does to it.
class SoakProgram {
 public:
  struct Files {
    std::filesystem::path folder;     // folder for all files of the session
    std::filesystem::path temporary;  // folder for the program's own temporary files
  };

  SoakProgram(std::size_t place, int life, const Files& files, double now_s);
  ~SoakProgram();
  SoakProgram(const SoakProgram&) = delete;
  SoakProgram& operator=(const SoakProgram&) = delete;

  const std::string& name() const { return life_.name; }
  std::filesystem::path report() const { return life_.report; }
  /// Returns the words before the program's own: its temporary folder, and a clock that can be set.
  std::vector<std::string> Environment() const;
  void Start(const std::vector<std::string>& command);

  /// Reads what the program has said, and counts what it takes. False: the program has ended.
  bool Look(double now_s);
  /// Gives the program a line of orders; a stopped one gets none.
  void Order(const std::string& line);
  void StopFor(bool stopped, double now_s);
  void StepClock(double seconds);
  void Kill();
  void DiskIsFull() { life_.disk_full = true; }
  std::string OutputOf() const { return program_->output(); }

  ProgramLog& log() { return log_; }
  bool stopped() const { return stopped_since_s_.has_value(); }
  /// Ends the program by SIGTERM, and measures how long that takes.
  void End();
  /// Returns what is left of it, once it has ended.
  SoakLife Life(double now_s);

 private:
  std::filesystem::path FileOf(const char* ending) const;

  Files files_;
  SoakLife life_;
  ProgramLog log_;
  int orders_ = -1;  // pipe by which the program gets lines
  double step_s_ = 0;
  std::optional<double> stopped_since_s_;
  double counted_s_ = -1;
  std::optional<Program> program_;
};

}  // namespace tandem::testing
