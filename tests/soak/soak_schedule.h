#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "scenes/generators/large/random_source.h"

namespace tandem::testing {

/// A program's place in the session of the endurance run. The first peer and the first viewer are
/// never killed, so that their memory can be judged over the whole run.
struct SoakPlaces {
  static constexpr std::size_t kPeers = 3;
  static constexpr std::size_t kViewers = 2;
  static constexpr std::size_t kPrograms = kPeers + kViewers;  // peers come first
  static constexpr std::size_t kAttacker = kPrograms;          // port of the flooding program

  /// "anna", "ben", "cleo", "vera", "will".
  static const char* NameOf(std::size_t place);
};

/// A fault that strikes the session of the endurance run.
struct SoakFault {
  enum class Kind : std::uint8_t {
    kKill,       // kill -9; the program starts again after `lasts_s`
    kStop,       // SIGSTOP, and SIGCONT after `lasts_s`
    kCut,        // no packet passes for `lasts_s`
    kClockStep,  // the wall clock of a program jumps by `step_s` and stays there
    kFullDisk,   // a peer starts again, and records onto a disk that becomes full
    kFlood,      // a program of the tests floods the session for `lasts_s`
    kCount
  };
  enum class Way : std::uint8_t { kOut, kIn, kBoth };
  static constexpr std::size_t kKinds = static_cast<std::size_t>(Kind::kCount);

  Kind kind = Kind::kKill;
  std::size_t place = 0;  // the struck program's; for a flood the attacker's
  double after_s = 0;     // calm before the fault
  double lasts_s = 0;
  Way way = Way::kBoth;  // direction of a cut, seen from the program
  double step_s = 0;     // step of the clock, forward or back
  int disk_kb = 0;       // room on the disk
  std::string flood{};   // mode of the attacker
};
const char* NameOf(SoakFault::Kind kind);
/// Returns an object with the numbers that the kind has.
nlohmann::ordered_json AsJson(const SoakFault& fault);

/// Returns the kinds that the words name, "kill,stop" for instance; all kinds if there are no
/// words. Unknown words name nothing.
std::vector<SoakFault::Kind> KindsIn(const std::string& words);

/// Draws faults of some kinds from a seed. Each round of draws has every kind once, in a drawn
/// order, so that a short run has all of them.
class SoakSchedule {
 public:
  explicit SoakSchedule(std::uint64_t seed, std::vector<SoakFault::Kind> kinds = KindsIn(""))
      : rng_(seed), kinds_(std::move(kinds)) {}

  SoakFault Next();

 private:
  RandomSource rng_;
  std::vector<SoakFault::Kind> kinds_;
  std::vector<SoakFault::Kind> round_;  // the kinds still to come, the next one last
};

}  // namespace tandem::testing
