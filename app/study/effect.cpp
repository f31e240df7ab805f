#include "app/study/effect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

double MeanOf(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? kNoNumber : sum / static_cast<double>(values.size());
}

using ValueOf = std::function<double(const ResultRow&)>;

struct Analysed {
  std::string name;
  std::string unit;
  ValueOf value;
};

std::vector<Analysed> AllAnalysed(const Study& study) {
  std::vector<Analysed> all;
  for (const TrialMeasure& measure : AllTrialMeasures()) {
    all.push_back({std::string(measure.name), std::string(measure.unit),
                   [value = measure.value](const ResultRow& row) {
                     return row.logged.measures.*value;
                   }});
  }
  for (const StudyQuestion& question : study.questions) {
    if (question.kind != QuestionKind::kScale) continue;
    all.push_back({"answer_" + question.key, "1 to 7", [key = question.key](const ResultRow& row) {
                     const auto found = row.logged.answers.find(key);
                     return found == row.logged.answers.end()
                                ? kNoNumber
                                : std::strtod(found->second.c_str(), nullptr);
                   }});
  }
  return all;
}

/// Returns each participant's mean in a condition, in the order of `participants`.
std::vector<double> ParticipantMeans(const std::vector<const ResultRow*>& rows,
                                     const std::vector<std::string>& participants,
                                     std::size_t condition, const ValueOf& value) {
  std::map<std::string, std::vector<double>> of;
  for (const ResultRow* row : rows) {
    const double number = value(*row);
    if (row->plan.condition == condition && std::isfinite(number)) {
      of[row->participant].push_back(number);
    }
  }
  std::vector<double> means;
  for (const std::string& participant : participants) means.push_back(MeanOf(of[participant]));
  return means;
}

std::vector<double> Finite(const std::vector<double>& values) {
  std::vector<double> finite;
  for (const double value : values) {
    if (std::isfinite(value)) finite.push_back(value);
  }
  return finite;
}

OrderedJson OrNull(double value) {
  return std::isfinite(value) ? OrderedJson(value) : OrderedJson();
}

OrderedJson AsJson(const MeanInterval& interval) {
  return {{"participants", interval.count},
          {"mean", OrNull(interval.mean)},
          {"low", OrNull(interval.low)},
          {"high", OrNull(interval.high)}};
}

}  // namespace

double StudentT975(int degrees_of_freedom) {
  constexpr std::array kTable{12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306,
                              2.262,  2.228, 2.201, 2.179, 2.160, 2.145, 2.131, 2.120,
                              2.110,  2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064,
                              2.060,  2.056, 2.052, 2.048, 2.045, 2.042};
  if (degrees_of_freedom < 1) return kNoNumber;
  const auto row = static_cast<std::size_t>(degrees_of_freedom - 1);
  if (row < kTable.size()) return kTable[row];
  // the expansion of Cornish and Fisher about the normal quantile
  constexpr double z = 1.959963985;
  const double n = degrees_of_freedom;
  return z + (z * z * z + z) / (4 * n) +
         (5 * std::pow(z, 5) + 16 * std::pow(z, 3) + 3 * z) / (96 * n * n);
}

MeanInterval IntervalOf(const std::vector<double>& values) {
  MeanInterval interval{static_cast<int>(values.size()), MeanOf(values), kNoNumber, kNoNumber,
                        kNoNumber};
  if (values.size() < 2) return interval;
  double squares = 0;
  for (const double value : values) squares += std::pow(value - interval.mean, 2);
  const auto count = static_cast<double>(values.size());
  interval.deviation = std::sqrt(squares / (count - 1));
  const double half = StudentT975(interval.count - 1) * interval.deviation / std::sqrt(count);
  interval.low = interval.mean - half;
  interval.high = interval.mean + half;
  return interval;
}

std::vector<MeasureEffect> EffectsOf(const Study& study, const std::vector<ResultRow>& rows) {
  std::vector<MeasureEffect> effects;
  std::vector<std::string> participants;
  for (const ResultRow& row : rows) {
    if (std::ranges::find(participants, row.participant) == participants.end()) {
      participants.push_back(row.participant);
    }
  }
  for (std::size_t task = 0; task < study.tasks.size(); ++task) {
    std::vector<const ResultRow*> of_task;
    std::set<std::size_t> conditions;
    for (const ResultRow& row : rows) {
      const StudyBlock& block = study.blocks[row.plan.block];
      const bool measured =
          row.logged.state == TrialState::kDone || row.logged.state == TrialState::kRan;
      if (block.task != task || block.practice || !measured) continue;
      of_task.push_back(&row);
      conditions.insert(row.plan.condition);
    }
    for (const Analysed& analysed : AllAnalysed(study)) {
      MeasureEffect effect{study.tasks[task].name, analysed.name, analysed.unit, 0, {}};
      bool any = false;
      for (const std::size_t condition : conditions) {
        ConditionEffect& one = effect.conditions.emplace_back();
        one.condition = condition;
        one.participants = ParticipantMeans(of_task, participants, condition, analysed.value);
        one.level = IntervalOf(Finite(one.participants));
        any = any || one.level.count > 0;
        const ConditionEffect& reference = effect.conditions.front();
        effect.reference = reference.condition;
        std::vector<double> differences;
        for (std::size_t i = 0; i < participants.size(); ++i) {
          differences.push_back(one.participants[i] - reference.participants[i]);
        }
        one.difference = IntervalOf(Finite(differences));
        one.effect_size = one.difference.deviation > 0
                              ? one.difference.mean / one.difference.deviation
                              : kNoNumber;
      }
      if (any) effects.push_back(std::move(effect));
    }
  }
  return effects;
}

std::string EffectsJson(const Study& study, const std::vector<MeasureEffect>& effects) {
  OrderedJson out = OrderedJson::array();
  for (const MeasureEffect& effect : effects) {
    OrderedJson conditions = OrderedJson::array();
    for (const ConditionEffect& one : effect.conditions) {
      OrderedJson row{{"condition", study.conditions[one.condition].name}};
      row.update(AsJson(one.level));
      row["difference"] = nullptr;
      if (one.condition != effect.reference) {
        row["difference"] = AsJson(one.difference);
        row["difference"]["effect_size"] = OrNull(one.effect_size);
      }
      conditions.push_back(std::move(row));
    }
    out.push_back({{"task", effect.task},
                   {"measure", effect.measure},
                   {"unit", effect.unit},
                   {"reference", study.conditions[effect.reference].name},
                   {"conditions", conditions}});
  }
  return JsonText(out, 2);
}

}  // namespace tandem
