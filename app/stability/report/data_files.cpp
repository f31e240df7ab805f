#include "app/stability/report/data_files.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <type_traits>

#include <nlohmann/json.hpp>

#include "app/stability/report/cell_facts.h"
#include "collab/lab/metrics/metrics_table.h"
#include "engine/base/text/csv_text.h"
#include "engine/base/text/hex.h"

namespace tandem {

namespace {

using OrderedJson = nlohmann::ordered_json;

// the fewest digits that read back to the same number; empty: not finite
std::string Exact(double value) {
  if (!std::isfinite(value)) return {};
  std::array<char, 40> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

std::string TrueOrFalse(bool value) {
  return value ? "TRUE" : "FALSE";  // the spellings that R reads
}

std::string LineOf(const std::vector<std::string>& values) {
  std::string line;
  for (const std::string& value : values) {
    if (&value != values.data()) line += ',';
    line += CsvText(value);
  }
  return line + '\n';
}

std::vector<std::string> ValuesOf(const CellRecord& record) {
  const CellFacts facts = FactsOf(record);
  const CellOutcome& outcome = record.outcome;
  const bool predicted = outcome.predicted.has_value();
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::string> values{
      std::to_string(record.cell.number),
      record.cell.key,
      facts.scene,
      std::to_string(facts.users),
      facts.hands,
      Exact(facts.delay_s),
      facts.network,
      Exact(facts.publish_hz),
      facts.law,
      TrueOrFalse(facts.gate),
      facts.motion,
      record.cell.expect == Expectation::kNothing ? "" : NameOf(record.cell.expect),
      NameOf(outcome.result.verdict),
      !predicted ? "" : (outcome.predicted->is_stable() ? "stable" : "not certainly"),
      Exact(StiffnessOf(record, facts)),
      Exact(predicted ? outcome.predicted->critical : kNone)};
  for (const MetricField& field : MetricFields()) {
    std::visit(
        [&](auto member) {
          const auto value = outcome.result.metrics.*member;
          if constexpr (std::is_same_v<std::remove_const_t<decltype(value)>, bool>) {
            values.push_back(TrueOrFalse(value));
          } else {
            values.push_back(Exact(static_cast<double>(value)));
          }
        },
        field.member);
  }
  values.push_back(Hex(outcome.result.digest));
  values.push_back(Exact(outcome.result.simulated_s));
  values.push_back(Exact(outcome.cpu_s));
  values.push_back(Exact(outcome.wall_s));
  values.push_back(outcome.result.fault ? outcome.result.fault->what : "");
  values.push_back(std::to_string(facts.seed));
  values.push_back(Exact(StiffnessOf(record, facts) / static_cast<double>(facts.users - 1)));
  return values;
}

OrderedJson JsonOf(const std::vector<SweepRow>& rows) {
  OrderedJson out = OrderedJson::array();
  for (const SweepRow& row : rows) {
    out.push_back({{"name", row.name}, {"bar", row.bar}, {"value", row.value}, {"pass", row.pass}});
  }
  return out;
}

}  // namespace

std::string CaseFileOf(const std::string& sweep, const CellRecord& record) {
  return "cases/" + sweep + "-cell-" + std::to_string(record.cell.number) + ".json";
}

std::string CsvOf(const Results& results) {
  std::vector<std::string> columns{
      "cell", "key",  "scene",  "users",  "hands",   "delay_s",   "network",       "publish_hz",
      "law",  "gate", "motion", "expect", "verdict", "predicted", "stiffness_N_m", "critical_N_m"};
  for (const MetricField& field : MetricFields()) columns.emplace_back(field.name);
  for (const char* name :
       {"digest", "simulated_s", "cpu_s", "wall_s", "fault", "seed", "link_stiffness_N_m"}) {
    columns.emplace_back(name);
  }
  std::string csv = LineOf(columns);
  for (const auto& numbered : results.records) csv += LineOf(ValuesOf(numbered.second));
  return csv;
}

std::string CsvOf(const ReportTable& table) {
  std::string csv = LineOf(table.columns);
  for (const std::vector<std::string>& row : table.rows) csv += LineOf(row);
  return csv;
}

std::string JsonOf(const ReportData& data) {
  OrderedJson sweeps = OrderedJson::array();
  for (const ReportSweep& sweep : data.sweeps) {
    OrderedJson cells = OrderedJson::array();
    for (const auto& numbered : sweep.results.records) {
      cells.push_back(OrderedJson::parse(tandem::LineOf(numbered.second)));
    }
    sweeps.push_back({{"header", OrderedJson::parse(tandem::LineOf(sweep.results.header))},
                      {"digest", sweep.summary.digest},
                      {"cells", cells}});
  }
  OrderedJson tables = OrderedJson::array();
  for (const ReportTable& table : data.tables) {
    tables.push_back({{"title", table.title},
                      {"note", table.note},
                      {"columns", table.columns},
                      {"rows", table.rows}});
  }
  OrderedJson series = OrderedJson::array();
  for (const ReportSeries& one : data.series) {
    series.push_back(
        {{"cell", one.cell}, {"why", one.why}, {"csv", one.csv}, {"same_digest", one.same}});
  }
  return OrderedJson{
             {"command", data.command}, {"version", data.version}, {"rows", JsonOf(data.AllRows())},
             {"sweeps", sweeps},        {"tables", tables},        {"series", series}}
             .dump(1, ' ', false, OrderedJson::error_handler_t::replace) +
         '\n';
}

}  // namespace tandem
