#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/stability/live/tap_hub.h"
#include "tests/soak/soak_program.h"
#include "tests/soak/soak_schedule.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {

/// A session of the product that the endurance run strikes with faults: three peers hold the peg of
/// peg_in_slot together and press it against the slot, two viewers look on. Each program has a port
/// of its own of a network of real packets, which is 50 ms late each way: 100 ms there and back.
class SoakSession {
 public:
  static constexpr double kDelayMs = 50;  // each way

  /// `longest_s`: the hands move for so long at least.
  explicit SoakSession(double longest_s);
  ~SoakSession();
  SoakSession(const SoakSession&) = delete;
  SoakSession& operator=(const SoakSession&) = delete;

  /// Starts all programs.
  void Begin();
  /// Watches all programs for so long; one that ends by itself is a failure of the test.
  void Watch(double for_s);
  /// Waits until all peers are coupled with one another and all viewers see all peers. Returns the
  /// seconds that took, or nothing if it took longer than `within_s`.
  std::optional<double> AwaitTogether(double within_s);
  /// Lets the fault begin and end.
  void Strike(const SoakFault& fault);
  /// Ends all programs, the viewer that is never killed last: it hears the peers' goodbyes.
  void End();

  double seconds() const;  // since the session was made
  const std::vector<SoakLife>& lives() const { return lives_; }
  const TapHub& hub() const { return *hub_; }
  /// Returns the files that programs left in their temporary folder.
  std::vector<std::string> LeftFiles() const;
  /// Returns the processes of the session that still run.
  std::vector<std::string> LeftProcesses() const;
  /// Returns the last lines of each program, for a person who looks for what went wrong.
  std::string LastWords() const;

 private:
  /// A disk of its own, that is full soon.
  class SmallDisk {
   public:
    SmallDisk(std::filesystem::path folder, int kilobytes);
    ~SmallDisk();
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;
    const std::filesystem::path& folder() const { return folder_; }

   private:
    std::filesystem::path folder_;
  };

  void Start(std::size_t place, const std::vector<std::string>& more = {});
  std::vector<std::string> PeerCommandLine(const SoakProgram& program, std::size_t place) const;
  std::vector<std::string> ViewerCommandLine(const SoakProgram& program) const;
  void Tick();
  bool Together();
  /// Returns whether the program says those words in time.
  bool AwaitSaid(std::size_t place, const std::string& words, double within_s);
  void Bury(std::size_t place);
  /// Ends a program by SIGTERM; the witness must hear its goodbye.
  void EndOne(std::size_t place, std::optional<std::size_t> witness);
  void Cut(const SoakFault& fault, bool cut);
  void FillDisk(const SoakFault& fault);
  void Flood(const SoakFault& fault);

  const std::chrono::steady_clock::time_point made_ = std::chrono::steady_clock::now();
  const double longest_s_;
  const std::string session_;
  ScratchFolder folder_;
  SoakProgram::Files files_;
  std::unique_ptr<TapHub> hub_;
  std::vector<std::unique_ptr<SmallDisk>> disks_;
  std::array<std::unique_ptr<SoakProgram>, SoakPlaces::kPrograms> programs_;
  std::array<int, SoakPlaces::kPrograms> lives_begun_{};
  std::vector<SoakLife> lives_;
  int floods_ = 0;
};

}  // namespace tandem::testing
