#pragma once

#include <string>
#include <vector>

#include "app/study/results_table.h"
#include "app/study/study.h"

namespace tandem {

/// A mean with its 95 % confidence interval by Student's t. NaN: too few values.
struct MeanInterval {
  int count = 0;
  double mean = 0;
  double low = 0;
  double high = 0;
  double deviation = 0;  // standard deviation of the values
};

MeanInterval IntervalOf(const std::vector<double>& values);

/// The 97.5 % quantile of Student's t, to three digits.
double StudentT975(int degrees_of_freedom);

/// A condition in the analysis of a measure: each participant counts once, by the mean of their
/// trials.
struct ConditionEffect {
  std::size_t condition = 0;  // into Study::conditions
  MeanInterval level;
  std::vector<double> participants;  // their means, NaN where one has none; in the study's order
  // paired differences from the reference, within participants; none for the reference itself
  MeanInterval difference;
  double effect_size = 0;  // Cohen's d_z: mean over standard deviation of the differences
};

/// A measure, or the answers to a question of the kind scale, of a task.
struct MeasureEffect {
  std::string task;
  std::string measure;
  std::string unit;
  std::size_t reference = 0;                // the first of the study's conditions that the task has
  std::vector<ConditionEffect> conditions;  // in the order of the study; the reference first
};

/// All measures that have a value, of trials that are done or measured and are no practice.
std::vector<MeasureEffect> EffectsOf(const Study& study, const std::vector<ResultRow>& rows);

/// [{"task", "measure", "unit", "reference", "conditions": [{"condition", "participants", "mean",
/// "low", "high", "difference": null or {"participants", "mean", "low", "high", "effect_size"}}]}],
/// indented, a number that is none as null.
std::string EffectsJson(const Study& study, const std::vector<MeasureEffect>& effects);

}  // namespace tandem
