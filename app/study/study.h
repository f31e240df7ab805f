#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collab/coupling_law.h"

namespace tandem {

/// What a trial may differ in. Its name is of results alone: no participant reads it.
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
  std::string scene;          // in place of the task's; empty: the task's
  double planted_slower = 1;  // factor of the time that modelled hands take: a dry run's effect
};

/// What has to be true of a trial that succeeds. A criterion that is not set does not count.
struct StudySuccess {
  bool out = false;  // the body has left what is fixed, and stays out
  std::optional<double> moved_mm =
      {};                             // the body is that far from its first place, and stays there
  std::optional<double> time_s = {};  // `out` or `moved_mm` is reached within
  std::optional<double> peak_force_N = {};  // at the hand, at the most
  std::optional<double> collisions = {};    // at the most
  double hold_s = 1;                        // the trial ends when the goal was kept for so long

  bool has_goal() const noexcept { return out || moved_mm; }
};

struct StudyTask {
  std::string name;
  std::string scene;  // by name or path, or one of the lab's: free, wall, slot, ball, off_centre
  std::string body;   // shared; empty: the scene's only one
  std::string instructions;
  double time_limit_s = 30;
  StudySuccess success;
  // modelled hands, the participant's and the partner's: names of the lab's or hand files; none:
  // those of the scene
  std::vector<std::string> hands;
  std::string motion;  // of the lab's, for hands without a file; empty: "move"
};

enum class StudyOrder : std::uint8_t { kWilliams, kShuffled, kAsWritten };

struct StudyBlock {
  std::string name;
  std::size_t task = 0;                 // into Study::tasks
  std::vector<std::size_t> conditions;  // into Study::conditions
  int repetitions = 1;                  // of all conditions
  StudyOrder order = StudyOrder::kWilliams;
  bool practice = false;  // left out of the analysis
  std::string instructions;
  double pause_s = 0;  // before the block, at least
};

enum class QuestionKind : std::uint8_t { kChoice, kScale, kText };

struct StudyQuestion {
  std::string key;  // of its column
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
  bool modelled_partner = true;  // else a person at another site
  int attempts = 2;              // how often a trial is begun at the most
  double publish_hz = 1000;
  std::string information;  // told before consent is asked for
  std::vector<StudyTask> tasks;
  std::vector<StudyCondition> conditions;
  std::vector<StudyBlock> blocks;
  std::vector<StudyQuestion> questions;
};

}  // namespace tandem
