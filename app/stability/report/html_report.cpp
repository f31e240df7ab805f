#include "app/stability/report/html_report.h"

#include <algorithm>
#include <cmath>

#include "app/picture/svg.h"
#include "app/stability/report/cell_facts.h"
#include "app/stability/report/data_files.h"
#include "app/stability/report/html_page.h"
#include "engine/base/text/markup.h"

namespace tandem {

namespace {

std::string Cell(const std::string& text, bool number, bool head = false) {
  const std::string element = head ? "th" : "td";
  return MarkupElement(number ? element + " class=\"n\"" : element, text);
}

bool IsNumber(const std::string& text) {
  return !text.empty() &&
         (text.find_first_not_of("+-0123456789.e") == std::string::npos || text == "any");
}

std::string TableOf(const ReportTable& table) {
  // a column is numeric if all its texts are numbers
  std::vector<bool> numbers(table.columns.size(), true);
  for (const auto& row : table.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (!row[i].empty() && !IsNumber(row[i])) numbers[i] = false;
    }
  }
  std::string out = "<div class=\"wide\"><table><thead><tr>";
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    out += Cell(table.columns[i], numbers[i], true);
  }
  out += "</tr></thead><tbody>\n";
  for (const auto& row : table.rows) {
    out += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) out += Cell(row[i], numbers[i]);
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string FigureOf(const Picture& picture, const std::string& caption, std::size_t sweep) {
  return "<figure data-sweep=\"s" + std::to_string(sweep) + "\">\n" +
         SvgOf(picture, SvgPlace::kInHtml) +
         (caption.empty() ? "" : MarkupElement("figcaption", caption)) + "</figure>\n";
}

std::string Fact(const std::string& name, const std::string& value) {
  return MarkupElement("dt", name) + "<dd>" + value + "</dd>\n";
}

std::string HeadOf(const ReportData& data, const std::vector<SweepRow>& rows) {
  const auto passed = std::ranges::count_if(rows, &SweepRow::pass);
  const bool all = static_cast<std::size_t>(passed) == rows.size();
  std::string out = "<h1>Stability of shared bodies under delay</h1>\n";
  if (rows.empty()) {
    out += "<p><span class=\"verdict\">the report judges no claim</span> ";
  } else {
    out += "<p><span class=\"verdict " + std::string(all ? "pass" : "fail") + "\">" +
           std::to_string(passed) + " of " + std::to_string(rows.size()) + " rows pass</span> ";
  }
  if (data.cells() > 0) out += std::to_string(data.cells()) + " experiments ";
  if (data.searches > 0) out += std::to_string(data.searches) + " boundaries searched";
  out += "</p>\n<dl>";
  out += Fact("this report", "<code>" + EscapedMarkup(data.command) + "</code>");
  out += Fact("made by", "tandem " + EscapedMarkup(data.version));
  for (const ReportSweep& sweep : data.sweeps) {
    const ResultsHeader& header = sweep.results.header;
    out += Fact("sweep", EscapedMarkup(header.sweep) + ": <code>" + EscapedMarkup(header.command) +
                             "</code>");
    out += Fact("", "seed " + std::to_string(header.seed) + ", digest <code>" +
                        EscapedMarkup(sweep.summary.digest) + "</code>, " +
                        std::to_string(sweep.results.records.size()) + " of " +
                        std::to_string(header.cells) + " cells, tandem " +
                        EscapedMarkup(header.version) + ", build <code>" +
                        EscapedMarkup(header.program) + "</code>, " +
                        TableNumber(sweep.summary.simulated_s) + " s simulated in " +
                        TableNumber(sweep.summary.cpu_s) + " s of processor time");
  }
  return out + "</dl>\n";
}

std::string RowsOf(const std::vector<SweepRow>& rows) {
  std::string out =
      "<h2>Acceptance</h2>\n<div class=\"wide\"><table><thead><tr><th>claim</th><th>bar</th><th "
      "class=\"n\">measured</th><th></th></tr></thead><tbody>\n";
  for (const SweepRow& row : rows) {
    out += "<tr>" + Cell(row.name, false) + Cell(row.bar, false) +
           Cell(TableNumber(row.value), true) + "<td class=\"" + (row.pass ? "pass" : "fail") +
           "\">" + (row.pass ? "pass" : "FAIL") + "</td></tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string CellRowOf(const CellRecord& record, std::size_t sweep, const std::string& name) {
  const CellFacts facts = FactsOf(record);
  const CaseResult& result = record.outcome.result;
  const Metrics& m = result.metrics;
  const double stiffness = StiffnessOf(record, facts);
  const bool predicted = record.outcome.predicted.has_value();
  const auto number = [](double value) {
    return Cell(TableNumber(value), true);
  };
  std::string out =
      "<tr id=\"s" + std::to_string(sweep) + "-" + std::to_string(record.cell.number) + "\">";
  const std::string cell = std::to_string(record.cell.number);
  out += "<td class=\"n\"><a href=\"" + EscapedMarkup(CaseFileOf(name, record)) + "\">" + cell +
         "</a></td>" + Cell(facts.scene, false) + number(static_cast<double>(facts.users)) +
         Cell(facts.hands, false) + number(1e3 * facts.delay_s) + Cell(facts.network, false) +
         number(facts.publish_hz) + Cell(facts.law + (facts.gate ? ", gated" : ""), false) +
         Cell(facts.motion, false);
  const bool bad =
      (record.cell.expect == Expectation::kStable && result.verdict != Verdict::kStable) ||
      (record.cell.expect == Expectation::kUnstable && result.verdict != Verdict::kUnstable) ||
      (predicted && record.outcome.predicted->is_stable() && result.verdict != Verdict::kStable);
  out += bad || result.fault ? "<td class=\"fail\">" : "<td>";
  out += EscapedMarkup(result.fault ? result.fault->what : NameOf(result.verdict)) + "</td>";
  out += Cell(record.cell.expect == Expectation::kNothing ? "" : NameOf(record.cell.expect), false);
  out += number(stiffness) +
         (predicted ? number(stiffness / record.outcome.predicted->critical) : Cell("", true));
  out += (m.diverged ? Cell("apart", true) : number(m.growth)) + number(1e3 * m.tail_rms) +
         number(1e3 * m.generated_J) + number(1e3 * m.peak_apart) + number(m.settle_s) +
         number(m.peak_force) + number(1e2 * m.clip_share);
  return out + "</tr>\n";
}

std::string CellsOf(const ReportSweep& sweep, std::size_t index) {
  std::string out = "<h3>All cells of " + EscapedMarkup(sweep.results.header.sweep) +
                    "</h3>\n<p>The number of a cell links to its case. <code>tandem stability run "
                    "CASE --series course.csv</code> runs it again bit for bit and writes its time "
                    "series; <code>tandem stability live CASE</code> runs it with real "
                    "peers.</p>\n<div class=\"wide\"><table><thead><tr>";
  const std::vector<std::pair<const char*, bool>> columns{{"cell", true},
                                                          {"scene", false},
                                                          {"users", true},
                                                          {"hands", false},
                                                          {"delay, ms", true},
                                                          {"network", false},
                                                          {"states, Hz", true},
                                                          {"law", false},
                                                          {"motion", false},
                                                          {"measured", false},
                                                          {"expected", false},
                                                          {"stiffness of all links, N/m", true},
                                                          {"of the boundary", true},
                                                          {"growth, 1/s", true},
                                                          {"tail, mm/s", true},
                                                          {"energy, mJ", true},
                                                          {"apart, mm", true},
                                                          {"settles, s", true},
                                                          {"hand, N", true},
                                                          {"gate acts, %", true}};
  for (const auto& column : columns) out += Cell(column.first, column.second, true);
  out += "</tr></thead><tbody>\n";
  for (const auto& numbered : sweep.results.records)
    out += CellRowOf(numbered.second, index, sweep.name);
  return out + "</tbody></table></div>\n";
}

constexpr const char* kMapCaption =
    "A tile is one run of whole peers with modelled hands. Its colour shows how fast the "
    "velocities grow or decay after the last push. Its mark is the verdict, which counts growth, "
    "the motion left at the end, and a distance of 0.5 m. Runs that came to rest have the colour "
    "of the fastest decay. Runs that went out of bounds have the colour of the fastest growth: 0.5 "
    "m apart, or above 100 mm/s at the end. Below the exact boundary every mode of the lumped "
    "coupling decays. Below the passive line every mode decays whatever the body touches. Below "
    "the any-delay line every mode decays at any delay.";

std::string MapsOf(const ReportSweep& sweep, std::size_t index) {
  std::string out;
  if (!sweep.maps.empty() || !sweep.others.empty()) {
    out += "<h2>Maps of " + EscapedMarkup(sweep.results.header.sweep) + "</h2>\n";
  }
  if (!sweep.maps.empty()) out += std::string("<p>") + kMapCaption + "</p>\n";
  for (const Picture& map : sweep.maps) out += FigureOf(map, "", index);
  if (sweep.maps_left_out > 0) {
    out += "<p>" + std::to_string(sweep.maps_left_out) +
           " smaller maps are left out; their cells are in the table.</p>\n";
  }
  for (const Picture& other : sweep.others) {
    out += FigureOf(other,
                    "Each mark is a run. Growth is cut at 2/s. Runs that went out of bounds are at "
                    "the top, runs at rest at the bottom, as in the maps.",
                    index);
  }
  return out;
}

}  // namespace

std::string HtmlOf(const ReportData& data) {
  const std::vector<SweepRow> rows = data.AllRows();
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width\">\n<title>Stability of shared bodies under "
      "delay</title>\n<style>" +
      std::string(kPageStyle) + "</style></head><body>\n";
  out += HeadOf(data, rows);
  if (!rows.empty()) out += RowsOf(rows);
  for (std::size_t i = 0; i < data.sweeps.size(); ++i) out += MapsOf(data.sweeps[i], i);
  if (!data.series.empty()) out += "<h2>Time series</h2>\n";
  for (const ReportSeries& one : data.series) {
    out += FigureOf(one.picture,
                    one.why + ". " + one.cell + ". All values: " + one.csv +
                        (one.same ? "" : ". The repeated run has another digest than the sweep's."),
                    0);
  }
  if (!data.tables.empty()) {
    out += data.sweeps.empty() ? "<h2>Tables</h2>\n" : "<h2>Other results</h2>\n";
  }
  for (const Picture& picture : data.pictures) out += FigureOf(picture, "", 0);
  for (const ReportTable& table : data.tables) {
    out += MarkupElement("h3", table.title) + "\n";
    if (!table.note.empty()) out += MarkupElement("p", table.note) + "\n";
    out += TableOf(table);
  }
  if (!data.sweeps.empty()) out += "<h2>Cells</h2>\n";
  for (std::size_t i = 0; i < data.sweeps.size(); ++i) out += CellsOf(data.sweeps[i], i);
  return out + "<div id=\"told\"></div>\n<script>" + kPageScript + "</script>\n</body></html>\n";
}

}  // namespace tandem
