#include "app/study/results_table.h"

#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "collab/coupling/coupling_limits.h"
#include "engine/base/text/csv_text.h"
#include "engine/base/text/json_text.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

const char* WordOf(bool value) {
  return value ? "TRUE" : "FALSE";  // the spellings that R reads
}

/// Removes the scene's folders, which may name a person.
std::string SceneNameOf(const std::string& scene) {
  return std::filesystem::path(scene).filename().string();
}

std::vector<std::string> CellsOf(const Study& study, const ResultRow& row) {
  const StudyBlock& block = study.blocks[row.plan.block];
  const StudyTask& task = study.tasks[block.task];
  const StudyCondition& condition = study.conditions[row.plan.condition];
  std::vector<std::string> cells{
      row.participant,
      block.name,
      std::to_string(row.plan.number),
      std::to_string(row.plan.repetition),
      std::to_string(row.plan.place),
      WordOf(block.practice),
      task.name,
      condition.name,
      SceneNameOf(condition.scene.empty() ? task.scene : condition.scene),
      CsvNumber(condition.delay_ms),
      CsvNumber(condition.jitter_ms),
      CsvNumber(condition.loss),
      CsvNumber(condition.burst_enter),
      CsvNumber(condition.burst_leave),
      CsvNumber(condition.burst_loss),
      condition.law,
      GainsText(condition),
      WordOf(condition.gate),
      NameOf(row.logged.state),
      std::to_string(row.logged.attempts),
      row.logged.begun_at};
  for (const TrialMeasure& measure : AllTrialMeasures()) {
    cells.push_back(CsvNumber(row.logged.measures.*measure.value));
  }
  for (const StudyQuestion& question : study.questions) {
    const auto found = row.logged.answers.find(question.key);
    cells.push_back(found == row.logged.answers.end() ? "" : found->second);
  }
  return cells;
}

ResultColumn ColumnOf(const StudyQuestion& question) {
  ResultColumn column{"answer_" + question.key, "text", "", "answer to: " + question.text};
  if (question.kind == QuestionKind::kScale) {
    column.kind = "whole number";
    column.unit = "1 to 7";
    if (!question.low.empty()) column.about += "; 1: " + question.low;
    if (!question.high.empty()) column.about += "; 7: " + question.high;
  } else if (question.kind == QuestionKind::kChoice) {
    column.about += "; one of:";
    for (const std::string& choice : question.choices) column.about += " '" + choice + "'";
  }
  return column;
}

std::string InTable(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\n') {
      out += ' ';
    } else {
      out += c == '|' ? std::string("\\|") : std::string(1, c);
    }
  }
  return out;
}

}  // namespace

std::string GainsText(const StudyCondition& condition) {
  std::string text;
  const CouplingLimits usual;
  for (const LimitName& limit : kLimitNames) {
    if (condition.gains.*limit.value == usual.*limit.value) continue;
    text += (text.empty() ? "" : " ") + std::string(limit.name) + "=" +
            CsvNumber(condition.gains.*limit.value);
  }
  return text;
}

std::string CsvNumber(double value) {
  if (!std::isfinite(value)) return {};
  std::array<char, 40> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::vector<ResultRow> RowsOf(const Study& study, const TrialLog& log) {
  std::vector<ResultRow> rows;
  const std::vector<std::string> pseudonyms = PseudonymsOf(study);
  for (int participant = 0; participant < study.participants; ++participant) {
    const std::string& name = pseudonyms[static_cast<std::size_t>(participant)];
    if (!log.ConsentOf(name) || log.Withdrew(name)) continue;
    for (const PlannedTrial& plan : TrialsOf(study, participant)) {
      rows.push_back({name, plan, log.TrialOf(name, plan.number)});
    }
  }
  return rows;
}

std::vector<ResultColumn> ColumnsOf(const Study& study) {
  std::vector<ResultColumn> columns{
      {"participant", "text", "", "pseudonym, drawn by the study's seed"},
      {"block", "text", "", "block of the study"},
      {"trial", "whole number", "", "number of the trial, as the participant saw it"},
      {"repetition", "whole number", "", "repetition of the block's conditions, from 1"},
      {"place", "whole number", "", "place in its repetition, from 1"},
      {"practice", "truth", "", "TRUE: the analysis leaves this trial out"},
      {"task", "text", "", "task of the block"},
      {"condition", "text", "", "name of the condition"},
      {"scene", "text", "", "scene of the trial"},
      {"condition_delay_ms", "number", "ms", "injected one-way delay, in both directions"},
      {"condition_jitter_ms", "number", "ms",
       "greatest further delay of a sample, evenly spread from 0"},
      {"condition_loss", "number", "0 to 1", "share of samples lost outside bursts"},
      {"condition_burst_enter", "number", "0 to 1",
       "chance, before each sample, that a burst begins"},
      {"condition_burst_leave", "number", "0 to 1",
       "chance, before each sample, that a burst ends"},
      {"condition_burst_loss", "number", "0 to 1", "share of samples lost within a burst"},
      {"condition_law", "text", "", "law by which stiffness follows delay"},
      {"condition_gains", "text", "", "limits of the law that differ from the defaults"},
      {"condition_gate", "truth", "", "TRUE: energy gates are on"},
      {"state", "text", "",
       "done; unanswered: measured, and its questions are open; cut: must run again; lost: cut as "
       "often as the study allows; planned: not begun"},
      {"attempts", "whole number", "", "number of times that the trial began"},
      {"begun_at", "text", "UTC", "time at which its last attempt began"}};
  for (const TrialMeasure& measure : AllTrialMeasures()) {
    columns.push_back({std::string(measure.name), "number", std::string(measure.unit),
                       std::string(measure.about)});
  }
  for (const StudyQuestion& question : study.questions) columns.push_back(ColumnOf(question));
  return columns;
}

std::string ResultsCsv(const Study& study, const std::vector<ResultRow>& rows) {
  std::string out;
  const auto add = [&out](const std::string& cell, bool first) {
    out += (first ? "" : ",") + CsvText(cell);
  };
  bool first = true;
  for (const ResultColumn& column : ColumnsOf(study)) {
    add(column.name, first);
    first = false;
  }
  out += "\n";
  for (const ResultRow& row : rows) {
    first = true;
    for (const std::string& cell : CellsOf(study, row)) {
      add(cell, first);
      first = false;
    }
    out += "\n";
  }
  return out;
}

std::string CodebookJson(const Study& study) {
  OrderedJson columns = OrderedJson::array();
  for (const ResultColumn& column : ColumnsOf(study)) {
    columns.push_back({{"name", column.name},
                       {"kind", column.kind},
                       {"unit", column.unit.empty() ? OrderedJson() : OrderedJson(column.unit)},
                       {"about", column.about}});
  }
  return JsonText(OrderedJson{{"study", study.name},
                              {"title", study.title},
                              {"file", "results.csv"},
                              {"row", "one trial of one participant"},
                              {"columns", columns}},
                  2) +
         "\n";
}

std::string CodebookText(const Study& study) {
  std::string out = "# Codebook of " + study.title +
                    "\n\n`results.csv` has a row for each trial of each participant. Its format is "
                    "RFC 4180: UTF-8, with commas. An empty cell has no value.\n\n| column | kind "
                    "| unit | meaning |\n|---|---|---|---|\n";
  for (const ResultColumn& column : ColumnsOf(study)) {
    out += "| `" + column.name + "` | " + column.kind + " | " + column.unit + " | " +
           InTable(column.about) + " |\n";
  }
  return out;
}

}  // namespace tandem
