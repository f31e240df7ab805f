#include "app/study/study_tables.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iterator>

#include "engine/base/text/markup.h"

namespace tandem {

namespace {

std::string Number(const std::string& text) {
  return MarkupElement("td class=\"n\"", text);
}

std::string BurstsOf(const StudyCondition& condition) {
  if (condition.burst_enter == 0) return "none";
  return PageFigure(condition.burst_enter) + ", " + PageFigure(condition.burst_leave) + ", " +
         PageFigure(condition.burst_loss);
}

/// Returns the number of a trial, linked to its case if the trial has run.
std::string LinkOf(const ResultRow& row) {
  const std::string number = std::to_string(row.plan.number);
  const bool has_run =
      row.logged.state == TrialState::kDone || row.logged.state == TrialState::kRan;
  if (!has_run) return number;
  return "<a href=\"" + EscapedMarkup(row.participant + "/" + TrialFolder(row.plan.number)) +
         "/case.json\">" + number + "</a>";
}

bool LeavesOutZero(const MeanInterval& interval) {
  return interval.low > 0 || interval.high < 0;
}

bool IsCounted(const Study& study, const ResultRow& row, std::size_t condition) {
  return row.plan.condition == condition && !study.blocks[row.plan.block].practice;
}

}  // namespace

std::string PageFigure(double value) {
  if (!std::isfinite(value)) return "";
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string PageInterval(const MeanInterval& interval) {
  if (!std::isfinite(interval.low)) return "";
  return PageFigure(interval.low) + " to " + PageFigure(interval.high);
}

bool AllTheSame(const MeasureEffect& effect) {
  std::vector<double> values;
  for (const ConditionEffect& one : effect.conditions) {
    std::ranges::copy_if(one.participants, std::back_inserter(values), [](double value) {
      return std::isfinite(value);
    });
  }
  return std::ranges::adjacent_find(values, std::ranges::not_equal_to()) == values.end();
}

std::string ConditionsTable(const Study& study) {
  std::string out =
      "<div class=\"wide\"><table><thead><tr><th>condition</th><th class=\"n\">delay, ms</th>"
      "<th class=\"n\">jitter, ms</th><th class=\"n\">loss</th><th class=\"n\">burst enter, leave, "
      "loss</th><th>law</th><th>gains</th><th>gate</th><th>scene</th></tr></thead><tbody>\n";
  for (const StudyCondition& condition : study.conditions) {
    const std::string gains = GainsText(condition);
    out += "<tr>" + MarkupElement("td", condition.name) + Number(PageFigure(condition.delay_ms)) +
           Number(PageFigure(condition.jitter_ms)) + Number(PageFigure(condition.loss)) +
           Number(BurstsOf(condition)) + MarkupElement("td", condition.law) +
           MarkupElement("td", gains.empty() ? "default" : gains) +
           MarkupElement("td", condition.gate ? "on" : "off") +
           MarkupElement("td", condition.scene.empty() ? "of the task" : condition.scene) +
           "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string SummaryTable(const Study& study, const std::vector<MeasureEffect>& effects) {
  std::string out =
      "<div class=\"wide\" style=\"max-height: "
      "none\"><table><thead><tr><th>task</th><th>measure</th><th>unit</th>"
      "<th>condition</th><th class=\"n\">participants</th><th class=\"n\">mean</th>"
      "<th class=\"n\">interval</th><th class=\"n\">difference</th><th class=\"n\">interval</th>"
      "<th class=\"n\">d<sub>z</sub></th></tr></thead><tbody>\n";
  for (const MeasureEffect& effect : effects) {
    for (const ConditionEffect& one : effect.conditions) {
      const bool reference = one.condition == effect.reference;
      const std::string difference = PageFigure(one.difference.mean);
      out += "<tr>" + MarkupElement("td", reference ? effect.task : "") +
             MarkupElement("td", reference ? effect.measure : "") +
             MarkupElement("td", reference ? effect.unit : "") +
             MarkupElement("td", study.conditions[one.condition].name) +
             Number(std::to_string(one.level.count)) + Number(PageFigure(one.level.mean)) +
             Number(PageInterval(one.level));
      if (reference) {
        out += "<td class=\"n\">reference</td><td></td><td></td></tr>\n";
        continue;
      }
      out += LeavesOutZero(one.difference) ? "<td class=\"n\"><b>" + difference + "</b></td>"
                                           : Number(difference);
      out += Number(PageInterval(one.difference)) + Number(PageFigure(one.effect_size)) + "</tr>\n";
    }
  }
  return out + "</tbody></table></div>\n";
}

std::string ChoicesTable(const Study& study, const std::vector<ResultRow>& rows) {
  std::string out;
  for (const StudyQuestion& question : study.questions) {
    if (question.kind != QuestionKind::kChoice) continue;
    out += "<div class=\"wide\"><table><thead><tr>" + MarkupElement("th", question.text);
    for (const std::string& choice : question.choices) {
      out += MarkupElement("th class=\"n\"", choice);
    }
    out += "</tr></thead><tbody>\n";
    for (std::size_t condition = 0; condition < study.conditions.size(); ++condition) {
      out += "<tr>" + MarkupElement("td", study.conditions[condition].name);
      for (const std::string& choice : question.choices) {
        const auto count = std::ranges::count_if(rows, [&](const ResultRow& row) {
          const auto answer = row.logged.answers.find(question.key);
          return IsCounted(study, row, condition) && answer != row.logged.answers.end() &&
                 answer->second == choice;
        });
        out += Number(std::to_string(count));
      }
      out += "</tr>\n";
    }
    out += "</tbody></table></div>\n";
  }
  return out;
}

std::string TrialsTable(const Study& study, const std::vector<ResultRow>& rows) {
  std::string out =
      "<div class=\"wide\"><table><thead><tr><th>participant</th><th class=\"n\">trial"
      "</th><th>block</th><th>condition</th><th>state</th>";
  for (const TrialMeasure& measure : AllTrialMeasures()) {
    out += MarkupElement("th class=\"n\"", std::string(measure.name));
  }
  out += "</tr></thead><tbody>\n";
  for (const ResultRow& row : rows) {
    out += "<tr>" + MarkupElement("td", row.participant) + "<td class=\"n\">" + LinkOf(row) +
           "</td>" + MarkupElement("td", study.blocks[row.plan.block].name) +
           MarkupElement("td", study.conditions[row.plan.condition].name) +
           MarkupElement("td", NameOf(row.logged.state));
    for (const TrialMeasure& measure : AllTrialMeasures()) {
      out += Number(PageFigure(row.logged.measures.*measure.value));
    }
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

}  // namespace tandem
