#include "app/study/study_page.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "app/picture/chart.h"
#include "app/picture/svg.h"
#include "app/stability/report/html_page.h"
#include "app/study/study_tables.h"
#include "engine/base/text/markup.h"

namespace tandem {

namespace {

constexpr PictureBox kLeastPlot{84, 56, 520, 300};
constexpr double kLetter = 9;  // largest width of a letter in a condition's name, pixels
constexpr Rgb kPerson{150, 165, 185};
constexpr Rgb kMean{0, 90, 160};
constexpr double kCap = 0.05;  // half width of the interval's ends, in conditions

/// Returns an axis round 0 and all values drawn, with a margin.
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

std::string Fact(const std::string& of, const std::string& value) {
  return "<dt>" + of + "</dt><dd>" + EscapedMarkup(value) + "</dd>";
}

std::string OfAll(std::size_t count, std::size_t all) {
  return std::to_string(count) + " of " + std::to_string(all);
}

std::string WhatWasRun(const Study& study, const std::vector<ResultRow>& rows,
                       const std::string& mode) {
  std::set<std::string> participants;
  std::size_t done = 0;
  std::size_t lost = 0;
  std::size_t again = 0;
  for (const ResultRow& row : rows) {
    participants.insert(row.participant);
    done += row.logged.state == TrialState::kDone ? 1 : 0;
    lost += row.logged.state == TrialState::kLost ? 1 : 0;
    again += row.logged.attempts > 1 ? 1 : 0;
  }
  return "<dl>" + Fact("mode", mode) +
         Fact("participants",
              OfAll(participants.size(), static_cast<std::size_t>(study.participants))) +
         Fact("trials done", OfAll(done, rows.size())) +
         Fact("trials with more than one attempt", std::to_string(again)) +
         Fact("trials lost", std::to_string(lost)) + Fact("seed", std::to_string(study.seed)) +
         "</dl>\n";
}

/// For a dry run, says what its results mean.
std::string WhatIsModelled(const Study& study) {
  std::string planted;
  for (const StudyCondition& condition : study.conditions) {
    if (condition.planted_slower == 1) continue;
    planted += " In " + condition.name + " its hands take " + PageFigure(condition.planted_slower) +
               " times as long; the analysis should find this difference.";
  }
  return "<p><b>This is a dry run: all hands are modelled, and answers are drawn at random. Its "
         "figures say nothing about persons.</b>" +
         EscapedMarkup(planted) + "</p>\n";
}

}  // namespace

Picture PictureOf(const Study& study, const MeasureEffect& effect) {
  PictureBox plot = kLeastPlot;
  std::size_t longest = 0;
  for (const ConditionEffect& one : effect.conditions) {
    longest = std::max(longest, study.conditions[one.condition].name.size());
  }
  // wide enough for the names side by side
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
                      name + ": " + PageFigure(one.level.mean) + " " + effect.unit});
    }
    picture.shapes.emplace_back(LabelShape{{chart.At(x, 0).x, plot.bottom() + 20},
                                           name,
                                           12,
                                           TextAnchor::kMiddle,
                                           kBlack,
                                           false,
                                           false});
  }
  // the horizontal axis has names instead of numbers
  const Axis y = AxisOf(effect);
  for (const Tick& tick : TicksOf(y, 6)) {
    const PicturePoint at = chart.At(0, tick.value);
    picture.shapes.emplace_back(
        LabelShape{{plot.x - 8, at.y + 4}, tick.text, 12, TextAnchor::kEnd, kBlack, false, false});
  }
  picture.shapes.emplace_back(RectangleShape{plot, {}, Stroke{kBlack, 1, {}}, {}});
  picture.shapes.emplace_back(LabelShape{
      {22, plot.y + 0.5 * plot.height}, y.label, 13, TextAnchor::kMiddle, kBlack, false, true});
  picture.shapes.emplace_back(LabelShape{
      {plot.x, plot.bottom() + 48},
      "dots: means over participants with 95 % intervals; thin lines: single participants",
      12,
      TextAnchor::kStart,
      {80, 80, 80},
      false,
      false});
  return picture;
}

std::string StudyPage(const Study& study, const std::vector<ResultRow>& rows,
                      const std::vector<MeasureEffect>& effects, const std::string& mode) {
  const std::string title = EscapedMarkup(study.title);
  std::string out = "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
                    title + "</title><style>" + kPageStyle + "</style></head><body>\n<h1>" + title +
                    "</h1>" + WhatWasRun(study, rows, mode);
  if (mode != "persons") out += WhatIsModelled(study);
  out +=
      "<h2>Conditions</h2>\n" + ConditionsTable(study) +
      "<h2>Effects</h2>\n<p>Each participant counts once in a condition, by the mean of their "
      "trials. Differences are paired within participants. Intervals are Student's, of 95 %. "
      "d<sub>z</sub> is the mean of the differences divided by their standard deviation. A "
      "difference is bold if its interval excludes zero. The page makes no correction for many "
      "measures, so look at those that were named before the study began. It leaves practice "
      "trials out.</p>\n" +
      SummaryTable(study, effects) +
      "<div style=\"display: grid; grid-template-columns: repeat(auto-fit, minmax(28em, 1fr))\">\n";
  std::string same;
  for (const MeasureEffect& effect : effects) {
    if (AllTheSame(effect)) {
      same += (same.empty() ? "" : ", ") + effect.measure;
    } else {
      out += "<figure>" + SvgOf(PictureOf(study, effect), SvgPlace::kInHtml) + "</figure>\n";
    }
  }
  out += "</div>\n";
  if (!same.empty()) {
    out +=
        "<p>The same for all participants in all conditions, so not drawn: " + EscapedMarkup(same) +
        ".</p>\n";
  }
  const std::string choices = ChoicesTable(study, rows);
  if (!choices.empty()) {
    out +=
        "<h2>Answers</h2>\n<p>Number of trials with each answer, without practice trials.</p>\n" +
        choices;
  }
  return out + "<h2>Trials</h2>\n<p>codebook.md explains each column and its unit.</p>\n" +
         TrialsTable(study, rows) + "</body></html>\n";
}

}  // namespace tandem
