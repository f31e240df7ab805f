#include "app/stability/data_files.h"

#include <algorithm>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "collab/lab/metrics_table.h"
#include "tests/app/stability/made_results.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using testing::TwentyCells;

TEST(DataFiles, HaveALineForEachCellWithEveryMetricToTheLastDigit) {
  Results results = TwentyCells();
  results.records.at(3).outcome.result.metrics.tail_rms = 0.1;  // no binary fraction
  std::istringstream csv(CsvOf(results));
  std::string head;
  std::getline(csv, head);
  EXPECT_THAT(head, StartsWith("cell,key,scene,"));
  for (const MetricField& field : MetricFields()) {
    EXPECT_THAT(head + ",", HasSubstr(std::string(field.name) + ","));
  }
  std::vector<std::string> lines;
  for (std::string line; std::getline(csv, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 20U);
  EXPECT_THAT(lines[3], HasSubstr(",0.10000000000000001,"));
  const auto commas = std::ranges::count(head, ',');
  for (const std::string& line : lines) EXPECT_EQ(std::ranges::count(line, ','), commas) << line;
}

TEST(DataFiles, QuoteTextsThatHaveCommas) {
  const ReportTable table{"t", "", {"a", "b"}, {{"1, 2", "he said \"no\""}}};
  EXPECT_EQ(CsvOf(table), "a,b\n\"1, 2\",\"he said \"\"no\"\"\"\n");
}

TEST(DataFiles, GiveAllOfTheReportAsJson) {
  ReportData data;
  data.command = "tandem stability report x";
  data.version = "0.1";
  ReportSweep& sweep = data.sweeps.emplace_back();
  sweep.results = TwentyCells();
  sweep.summary = Summarize(sweep.results);
  data.tables.push_back({"t", "n", {"a"}, {{"1"}}});
  const auto json = nlohmann::json::parse(JsonOf(data));
  EXPECT_EQ(json["sweeps"][0]["cells"].size(), 20U);
  EXPECT_EQ(json["sweeps"][0]["header"]["seed"], 3);
  EXPECT_EQ(json["sweeps"][0]["digest"], DigestOf(sweep.results));
  EXPECT_EQ(json["sweeps"][0]["cells"][7]["metrics"]["stiffness"], 90.0);
  EXPECT_EQ(json["rows"].size(), data.AllRows().size());
  EXPECT_EQ(json["tables"][0]["rows"][0][0], "1");
}

}  // namespace
}  // namespace tandem
