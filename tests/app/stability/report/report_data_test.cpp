#include "app/stability/report/report_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/app/stability/report/made_results.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::TwentyCells;

TEST(ReportData, AcceptsAFileOrAFolderOfResults) {
  const ScratchFolder folder;
  ASSERT_FALSE(WriteResults(folder.path() / "cells.jsonl", TwentyCells()));
  ReportData data;
  ASSERT_FALSE(AddFile(folder.path(), data));
  ASSERT_FALSE(AddFile(folder.path() / "cells.jsonl", data));
  ASSERT_EQ(data.sweeps.size(), 2U);
  EXPECT_EQ(data.cells(), 40U);
  EXPECT_EQ(data.sweeps[0].name, "made");
  EXPECT_EQ(data.sweeps[1].name, "made-2");
  EXPECT_EQ(data.sweeps[0].summary.digest, data.sweeps[1].summary.digest);
  EXPECT_EQ(data.sweeps[0].summary.cells, 20U);
  // rows of two sweeps are told apart
  EXPECT_THAT(data.AllRows().at(0).name, HasSubstr("made: "));
}

TEST(ReportData, TurnsArraysIntoTablesAndRowsIntoClaims) {
  const ScratchFolder folder;
  const auto file = folder.Write("press.json", R"({"publish_hz": 1000, "type1": [
      {"motion": "press", "calm": true, "unrest_mm": 0.01234567},
      {"motion": "tap", "calm": false, "holds_at_s": [0, 0.02], "speed": null}],
      "rows": [{"name": "speed", "bar": ">= 200", "value": 312.5, "pass": true}]})");
  ReportData data;
  const auto fault = AddFile(file, data);
  ASSERT_FALSE(fault) << fault->what;
  ASSERT_EQ(data.tables.size(), 1U);
  const ReportTable& table = data.tables[0];
  EXPECT_THAT(table.title, HasSubstr("type 1"));
  EXPECT_EQ(table.note, "publish_hz 1000");
  EXPECT_THAT(table.columns, ElementsAre("motion", "calm", "unrest_mm", "holds_at_s", "speed"));
  EXPECT_THAT(table.rows.at(0), ElementsAre("press", "yes", "0.0123", "", ""));
  EXPECT_THAT(table.rows.at(1), ElementsAre("tap", "no", "", "0, 0.02", "-"));
  ASSERT_EQ(data.AllRows().size(), 1U);
  EXPECT_EQ(data.AllRows()[0].value, 312.5);
}

TEST(ReportData, ShowsOtherRowsAsATable) {
  const ScratchFolder folder;
  ReportData data;
  ASSERT_FALSE(AddFile(
      folder.Write("boundary.json", R"({"rows": [{"delay_s": 0.1, "ratio": 1.02}]})"), data));
  ASSERT_EQ(data.tables.size(), 1U);
  EXPECT_EQ(data.tables[0].title, "boundary");
  EXPECT_TRUE(data.AllRows().empty());
}

TEST(ReportData, NamesUnusableFiles) {
  const ScratchFolder folder;
  ReportData data;
  EXPECT_THAT(AddFile(folder.Write("a.json", "[1, 2"), data)->what,
              HasSubstr("a.json: line 1, column 6: syntax error"));
  EXPECT_THAT(AddFile(folder.Write("b.jsonl", "{}\n"), data)->what, HasSubstr("b.jsonl"));
  EXPECT_THAT(AddFile(folder.path() / "none.json", data)->what,
              HasSubstr("none.json: there is no such file"));
}

TEST(ReportData, DifferentDigestOfTheSameBuildFailsItsRow) {
  ReportData data;
  data.series.resize(3);
  for (ReportSeries& one : data.series) one.same = true;
  EXPECT_TRUE(data.AllRows().empty());  // all of other builds
  for (ReportSeries& one : data.series) one.same_build = true;
  EXPECT_TRUE(data.AllRows().at(0).pass);
  data.series[1].same = false;
  EXPECT_FALSE(data.AllRows().at(0).pass);
}

TEST(ReportData, ShowsABoundaryAsTextAndPicture) {
  const ScratchFolder folder;
  const auto file = folder.Write("b.json", R"({"pass": true, "rows": [], "boundary": [
      {"hand": "off", "delay_s": 0.1, "law": "p+dd", "users": 2, "network": "jitter 20 ms, loss 5 %",
       "seed": 3, "predicted_N_m": 100.0, "onset_hz": 1.5, "runs": 9, "judged": false, "pass": true,
       "measured_N_m": 104.0, "ratio": 1.04},
      {"hand": "off", "delay_s": 0.02, "law": "constant", "users": 2, "network": "clean", "seed": 1,
       "predicted_N_m": 500.0, "onset_hz": 4.5, "runs": 7, "judged": true, "pass": true,
       "measured_N_m": null, "ratio": null}]})");
  ReportData data;
  const auto fault = AddFile(file, data);
  ASSERT_FALSE(fault) << fault->what;
  ASSERT_EQ(data.tables.size(), 1U);
  EXPECT_THAT(
      data.tables[0].columns,
      ElementsAre("hand", "one-way delay, ms", "law", "users", "network", "seed", "exact, N/m",
                  "measured, N/m", "measured / exact", "onset, Hz", "runs", "bar", "holds"));
  EXPECT_THAT(data.tables[0].rows.at(0),
              ElementsAre("off", "100", "p+dd", "2", "jitter 20 ms, loss 5 %", "3", "100", "104",
                          "1.04", "1.5", "9", "none", "-"));
  EXPECT_THAT(data.tables[0].rows.at(1),
              ElementsAre("off", "20", "constant", "2", "clean", "1", "500",
                          "none up to 4 times that", "-", "4.5", "7", ">= 0.95", "yes"));
  EXPECT_EQ(data.searches, 2U);
  ASSERT_EQ(data.pictures.size(), 1U);
  std::vector<std::string> hints;
  for (const PictureShape& shape : data.pictures[0].shapes) {
    const auto* const mark = std::get_if<MarkerShape>(&shape);
    if (mark != nullptr && !mark->hint.empty()) hints.push_back(mark->hint);
  }
  // the legend's words end within the picture, at half a size for a letter
  std::string legend;
  for (const PictureShape& shape : data.pictures[0].shapes) {
    const auto* const label = std::get_if<LabelShape>(&shape);
    if (label == nullptr || label->anchor != TextAnchor::kStart) continue;
    legend += label->text;
    EXPECT_LT(label->at.x + 0.5 * label->size * static_cast<double>(label->text.size()),
              data.pictures[0].width)
        << label->text;
  }
  EXPECT_THAT(legend, HasSubstr("hands off, p+dd, 2 users, jitter 20 ms, loss 5 %"));
  EXPECT_THAT(hints, ElementsAre("hands off, p+dd, 2 users, jitter 20 ms, loss 5 %, 100 ms: "
                                 "measured 104 N/m, exact 100 N/m"));
}

// A logarithmic axis has no place for a delay of 0.
TEST(ReportData, ShowsABoundaryWithoutDelayAsATableOnly) {
  for (const char* delay : {"0", "-0.1"}) {
    const ScratchFolder folder;
    ReportData data;
    ASSERT_FALSE(
        AddFile(folder.Write("b.json", std::string(R"({"boundary": [{"hand": "off", )") +
                                           R"("predicted_N_m": 100, "delay_s": )" + delay + "}]}"),
                data));
    EXPECT_EQ(data.pictures.size(), 0U) << delay;
    ASSERT_EQ(data.tables.size(), 1U);
    EXPECT_EQ(data.searches, 0U);
  }
}

TEST(ReportData, TruncatesUnusedTables) {
  std::string rows;
  for (int i = 0; i < 10'002; ++i) {
    rows += (i == 0 ? "" : ", ") + std::string(R"({"a)") + std::to_string(i % 103) + R"(": 1})";
  }
  const ScratchFolder folder;
  ReportData data;
  ASSERT_FALSE(AddFile(folder.Write("wide.json", R"({"rows": [)" + rows + "]}"), data));
  ASSERT_EQ(data.tables.size(), 1U);
  EXPECT_EQ(data.tables[0].columns.size(), 100U);
  EXPECT_EQ(data.tables[0].rows.size(), 10'000U);
  EXPECT_EQ(data.tables[0].note, "not shown here: columns 3, rows 2");
}

}  // namespace
}  // namespace tandem
