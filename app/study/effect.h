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

/// Returns the 97.5 % quantile of Student's t, to three digits.
double StudentT975(int degrees_of_freedom);

/// A condition in the analysis of a measure. Each participant counts once, by the mean of their
/// trials.
struct ConditionEffect {
  std::size_t condition = 0;  // index into Study::conditions
  MeanInterval level;
  std::vector<double> participants;  // participants' means in the study's order; NaN: no mean
  // paired differences from the reference, within participants; zeros for the reference itself
  MeanInterval difference;
  double effect_size = 0;  // Cohen's d_z: mean over standard deviation of the differences; NaN:
                           // deviation 0
};

/// The effects on a measure of a task, or on the answers to a question of the kind scale.
struct MeasureEffect {
  std::string task;
  std::string measure;
  std::string unit;
  std::size_t reference = 0;                // reference condition: the first of the study's that
                                            // the task has
  std::vector<ConditionEffect> conditions;  // conditions in the study's order; the reference first
};

/// Analyses all measures that have a value. Uses trials that are done or measured, without
/// practice.
std::vector<MeasureEffect> EffectsOf(const Study& study, const std::vector<ResultRow>& rows);

/// Writes [{"task", "measure", "unit", "reference", "conditions": [{"condition", "participants",
/// "mean", "low", "high", "difference": null or {"participants", "mean", "low", "high",
/// "effect_size"}}]}], indented, with null for NaN.
std::string EffectsJson(const Study& study, const std::vector<MeasureEffect>& effects);

}  // namespace tandem
