#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collab/coupling/coupling_law.h"

namespace tandem {

/// The parameters in which trials may differ. The name stands in results alone; no participant
/// reads it.
struct StudyCondition {
  std::string name;
  double delay_ms = 0;  // one way, in both directions
  double jitter_ms = 0;
  double loss = 0;  // share of samples
  double burst_enter = 0;
  double burst_leave = 1;
  double burst_loss = 1;
  std::string law = DefaultLaw()->name();
  CouplingLimits gains;
  bool gate = true;
  std::string scene;          // replaces the task's scene; empty: the task's
  double planted_slower = 1;  // factor on the times of modelled hands, to plant an effect in a dry
                              // run
};

/// The criteria of a trial's success. A criterion that is not set does not count.
struct StudySuccess {
  bool out = false;                     // true: the body must leave what is fixed and stay out
  std::optional<double> moved_mm = {};  // the body must be at least so far from its first place,
                                        // and stay there
  std::optional<double> time_s = {};    // longest time until `out` or `moved_mm` is reached
  std::optional<double> peak_force_N = {};  // largest force at the hand
  std::optional<double> collisions = {};    // largest number
  double hold_s = 1;                        // time for which the goal is kept until the trial ends

  bool has_goal() const noexcept { return out || moved_mm; }
};

struct StudyTask {
  std::string name;
  std::string scene;  // name or path, or a scene of the lab: free, wall, slot, ball, off_centre
  std::string body;   // shared body; empty: the scene's only body
  std::string instructions;
  double time_limit_s = 30;
  StudySuccess success;
  // modelled hands of the participant and the partner: names of the lab's hands, or hand files;
  // empty: the scene's hands
  std::vector<std::string> hands;
  std::string motion;  // motion of the lab, for hands without a file; empty: "move"
};

enum class StudyOrder : std::uint8_t { kWilliams, kShuffled, kAsWritten };

struct StudyBlock {
  std::string name;
  std::size_t task = 0;                 // index into Study::tasks
  std::vector<std::size_t> conditions;  // indices into Study::conditions
  int repetitions = 1;                  // repetitions of all conditions
  StudyOrder order = StudyOrder::kWilliams;
  bool practice = false;  // true: the analysis leaves the block out
  std::string instructions;
  double pause_s = 0;  // shortest pause before the block
};

enum class QuestionKind : std::uint8_t { kChoice, kScale, kText };

struct StudyQuestion {
  std::string key;  // key of its column
  std::string text;
  QuestionKind kind = QuestionKind::kScale;
  std::vector<std::string> choices;
  std::string low;   // meaning of 1
  std::string high;  // meaning of 7
};

inline constexpr int kScaleMost = 7;
inline constexpr std::size_t kLongestAnswer = 500;  // bytes of text

/// A delay-injection experiment with persons (docs/studies.md).
struct Study {
  std::string name;
  std::string title;
  std::uint64_t seed = 1;
  int participants = 1;
  bool modelled_partner = true;  // otherwise a person at another site
  int attempts = 2;              // largest number of times that a trial is begun
  double publish_hz = 1000;
  std::string information;  // text shown before consent is asked for
  std::vector<StudyTask> tasks;
  std::vector<StudyCondition> conditions;
  std::vector<StudyBlock> blocks;
  std::vector<StudyQuestion> questions;
};

}  // namespace tandem
