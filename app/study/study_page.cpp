#include "app/study/study_page.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "app/picture/chart.h"
#include "app/picture/svg.h"
#include "app/stability/html_page.h"
#include "engine/base/markup.h"

namespace tandem {

namespace {

constexpr PictureBox kLeastPlot{84, 56, 520, 300};
constexpr double kLetter = 9;  // width of one of a condition's name, at the most
constexpr Rgb kPerson{150, 165, 185};
constexpr Rgb kMean{0, 90, 160};
constexpr double kCap = 0.05;  // half of the interval's ends, in conditions

std::string Figure(double value) {
  if (!std::isfinite(value)) return "";
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

std::string Element(const std::string& element, const std::string& text) {
  return "<" + element + ">" + EscapedMarkup(text) + "</" + element.substr(0, element.find(' ')) +
         ">";
}

std::string Number(const std::string& text) {
  return Element("td class=\"n\"", text);
}

std::string Between(const MeanInterval& interval) {
  if (!std::isfinite(interval.low)) return "";
  return Figure(interval.low) + " to " + Figure(interval.high);
}

std::string EffectTable(const Study& study, const MeasureEffect& effect) {
  std::string out =
      "<div class=\"wide\"><table><thead><tr><th>condition</th><th class=\"n\">participants</th>"
      "<th class=\"n\">mean</th><th class=\"n\">95 % interval</th><th class=\"n\">difference "
      "from " +
      EscapedMarkup(study.conditions[effect.reference].name) +
      "</th><th class=\"n\">95 % interval</th><th class=\"n\">effect size d<sub>z</sub></th></tr>"
      "</thead><tbody>\n";
  for (const ConditionEffect& one : effect.conditions) {
    const bool is_reference = one.condition == effect.reference;
    out += "<tr>" + Element("td", study.conditions[one.condition].name) +
           Number(std::to_string(one.level.count)) + Number(Figure(one.level.mean)) +
           Number(Between(one.level)) + Number(is_reference ? "" : Figure(one.difference.mean)) +
           Number(is_reference ? "" : Between(one.difference)) +
           Number(is_reference ? "" : Figure(one.effect_size)) + "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string ConditionsTable(const Study& study) {
  std::string out =
      "<div class=\"wide\"><table><thead><tr><th>condition</th><th class=\"n\">delay, ms</th>"
      "<th class=\"n\">jitter, ms</th><th class=\"n\">loss</th><th class=\"n\">burst enter, leave, "
      "loss</th><th>law</th><th>gate</th><th>scene</th></tr></thead><tbody>\n";
  for (const StudyCondition& condition : study.conditions) {
    out += "<tr>" + Element("td", condition.name) + Number(Figure(condition.delay_ms)) +
           Number(Figure(condition.jitter_ms)) + Number(Figure(condition.loss)) +
           Number(Figure(condition.burst_enter) + ", " + Figure(condition.burst_leave) + ", " +
                  Figure(condition.burst_loss)) +
           Element("td", condition.law) + Element("td", condition.gate ? "on" : "off") +
           Element("td", condition.scene.empty() ? "of the task" : condition.scene) + "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

/// The number of a trial, as a link to its case where it has run.
std::string LinkOf(const ResultRow& row) {
  const std::string number = std::to_string(row.plan.number);
  const bool has_run =
      row.logged.state == TrialState::kDone || row.logged.state == TrialState::kRan;
  if (!has_run) return number;
  return "<a href=\"" + EscapedMarkup(row.participant + "/" + TrialFolder(row.plan.number)) +
         "/case.json\">" + number + "</a>";
}

std::string TrialsTable(const Study& study, const std::vector<ResultRow>& rows) {
  std::string out =
      "<div class=\"wide\"><table><thead><tr><th>participant</th><th class=\"n\">trial"
      "</th><th>block</th><th>condition</th><th>state</th>";
  for (const TrialMeasure& measure : AllTrialMeasures()) {
    out += Element("th class=\"n\"", std::string(measure.name));
  }
  out += "</tr></thead><tbody>\n";
  for (const ResultRow& row : rows) {
    out += "<tr>" + Element("td", row.participant) + "<td class=\"n\">" + LinkOf(row) + "</td>" +
           Element("td", study.blocks[row.plan.block].name) +
           Element("td", study.conditions[row.plan.condition].name) +
           Element("td", NameOf(row.logged.state));
    for (const TrialMeasure& measure : AllTrialMeasures()) {
      out += Number(Figure(row.logged.measures.*measure.value));
    }
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

/// Least and greatest of all that is drawn, a little apart from the frame.
Axis AxisOf(const MeasureEffect& effect) {
  double least = 0;
  double most = 0;
  const auto see = [&](double value) {
    if (!std::isfinite(value)) return;
    least = std::min(least, value);
    most = std::max(most, value);
  };
  for (const ConditionEffect& one : effect.conditions) {
    for (const double value : one.participants) see(value);
    see(one.level.low);
    see(one.level.high);
  }
  if (most == least) most = least + 1;
  return {effect.measure + ", " + effect.unit, least < 0 ? 1.08 * least : 0, 1.08 * most, false};
}

}  // namespace

Picture PictureOf(const Study& study, const MeasureEffect& effect) {
  PictureBox plot = kLeastPlot;
  std::size_t longest = 0;
  for (const ConditionEffect& one : effect.conditions) {
    longest = std::max(longest, study.conditions[one.condition].name.size());
  }
  // names stand beside one another
  plot.width = std::max(plot.width, static_cast<double>(effect.conditions.size()) * kLetter *
                                        static_cast<double>(longest + 2));
  Picture picture{effect.task + "-" + effect.measure,
                  effect.measure + " by condition, task " + effect.task,
                  plot.right() + 36,
                  430,
                  {}};
  const auto conditions = static_cast<double>(effect.conditions.size());
  picture.shapes.emplace_back(
      LabelShape{{plot.x, 28}, picture.title, 15, TextAnchor::kStart, kBlack, true, false});
  Chart chart(picture, plot, {"", -0.5, conditions - 0.5, false}, AxisOf(effect));
  const std::size_t participants =
      effect.conditions.empty() ? 0 : effect.conditions[0].participants.size();
  for (std::size_t person = 0; person < participants; ++person) {
    std::vector<PicturePoint> way;
    for (std::size_t i = 0; i < effect.conditions.size(); ++i) {
      way.push_back({static_cast<double>(i), effect.conditions[i].participants[person]});
    }
    chart.DrawCurve(way, {kPerson, 1, {}});
  }
  for (std::size_t i = 0; i < effect.conditions.size(); ++i) {
    const ConditionEffect& one = effect.conditions[i];
    const auto x = static_cast<double>(i);
    const PicturePoint at = chart.At(x, one.level.mean);
    if (std::isfinite(one.level.low)) {
      chart.DrawCurve({{x, one.level.low}, {x, one.level.high}}, {kMean, 2.2, {}});
      for (const double end : {one.level.low, one.level.high}) {
        chart.DrawCurve({{x - kCap, end}, {x + kCap, end}}, {kMean, 2.2, {}});
      }
    }
    const std::string name = study.conditions[one.condition].name;
    if (std::isfinite(one.level.mean)) {
      picture.shapes.emplace_back(
          MarkerShape{at, MarkerKind::kDot, 10, kMean,
                      name + ": " + Figure(one.level.mean) + " " + effect.unit});
    }
    picture.shapes.emplace_back(LabelShape{{chart.At(x, 0).x, plot.bottom() + 20},
                                           name,
                                           12,
                                           TextAnchor::kMiddle,
                                           kBlack,
                                           false,
                                           false});
  }
  // the horizontal axis has names in place of numbers
  const Axis y = AxisOf(effect);
  for (const Tick& tick : TicksOf(y, 6)) {
    const PicturePoint at = chart.At(0, tick.value);
    picture.shapes.emplace_back(
        LabelShape{{plot.x - 8, at.y + 4}, tick.text, 12, TextAnchor::kEnd, kBlack, false, false});
  }
  picture.shapes.emplace_back(RectangleShape{plot, {}, Stroke{kBlack, 1, {}}, {}});
  picture.shapes.emplace_back(LabelShape{
      {22, plot.y + 0.5 * plot.height}, y.label, 13, TextAnchor::kMiddle, kBlack, false, true});
  picture.shapes.emplace_back(
      LabelShape{{plot.x, plot.bottom() + 48},
                 "dots: means over participants with 95 % intervals; thin lines: participants",
                 12,
                 TextAnchor::kStart,
                 {80, 80, 80},
                 false,
                 false});
  return picture;
}

std::string StudyPage(const Study& study, const std::vector<ResultRow>& rows,
                      const std::vector<MeasureEffect>& effects, const std::string& mode) {
  std::set<std::string> participants;
  std::size_t done = 0;
  for (const ResultRow& row : rows) {
    participants.insert(row.participant);
    done += row.logged.state == TrialState::kDone ? 1 : 0;
  }
  std::string out = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">" +
                    Element("title", study.title) + "<style>" + kPageStyle +
                    "</style></head><body>\n" + Element("h1", study.title) + "<dl>" +
                    Element("dt", "mode") + Element("dd", mode) + Element("dt", "participants") +
                    Element("dd", std::to_string(participants.size()) + " of " +
                                      std::to_string(study.participants)) +
                    Element("dt", "trials done") +
                    Element("dd", std::to_string(done) + " of " + std::to_string(rows.size())) +
                    Element("dt", "seed") + Element("dd", std::to_string(study.seed)) + "</dl>\n" +
                    Element("h2", "Conditions") + "\n" + ConditionsTable(study) +
                    Element("h2", "Effects") + "\n" +
                    Element("p",
                            "Each participant counts once in a condition, by the mean of their "
                            "trials. Intervals are Student's. Differences are paired within "
                            "participants, and an effect size is their mean over their standard "
                            "deviation. Practice trials are left out.");
  for (const MeasureEffect& effect : effects) {
    out += Element("h3", effect.measure + " (" + effect.unit + "), task " + effect.task) +
           "\n<figure>" + SvgOf(PictureOf(study, effect), SvgPlace::kInHtml) + "</figure>\n" +
           EffectTable(study, effect);
  }
  return out + Element("h2", "Trials") + "\n" + TrialsTable(study, rows) + "</body></html>\n";
}

}  // namespace tandem
