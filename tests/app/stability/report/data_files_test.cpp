#include "app/stability/report/data_files.h"

#include <algorithm>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "collab/lab/metrics/metrics_table.h"
#include "tests/app/stability/report/made_results.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;
using testing::TwentyCells;

TEST(DataFiles, HaveOneExactRowPerCell) {
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
  EXPECT_THAT(lines[3], HasSubstr(",0.1,"));
  const auto commas = std::ranges::count(head, ',');
  for (const std::string& line : lines) EXPECT_EQ(std::ranges::count(line, ','), commas) << line;
}

TEST(DataFiles, QuoteTextWithCommas) {
  const ReportTable table{"t", "", {"a", "b"}, {{"1, 2", "he said \"no\""}}};
  EXPECT_EQ(CsvOf(table), "a,b\n\"1, 2\",\"he said \"\"no\"\"\"\n");
}

TEST(DataFiles, ContainTheWholeReportAsJson) {
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

// A case's stiffness is that of all links of a user: among three users a link has half of it.
TEST(DataFiles, ContainLinkStiffnessAndSeed) {
  Results results = TwentyCells();
  testing::ReplaceInCase(results.records.at(7), "\"users\":2", "\"users\":3");
  std::istringstream csv(CsvOf(results));
  std::string line;
  std::getline(csv, line);
  EXPECT_THAT(line, ::testing::EndsWith(",fault,seed,link_stiffness_N_m"));
  for (int i = 0; i < 8; ++i) std::getline(csv, line);
  EXPECT_THAT(line, ::testing::EndsWith(",,7,45"));  // 45 N/m of 90
}

TEST(DataFiles, DescribeCustomNetworksAndHands) {
  Results results = TwentyCells();
  testing::ReplaceInCase(results.records.at(0), "\"clean\"",
                         R"({"jitter_ms":20,"loss":0.05,"schedule":[{"at_s":2,"delay_s":0.3}]})");
  testing::ReplaceInCase(results.records.at(0), "\"heavy\"",
                         R"({"mass_kg":1.2,"damping_Ns_m":5},{"file":"hands/left.json"})");
  const std::string csv = CsvOf(results);
  EXPECT_THAT(csv, HasSubstr("\"jitter 20 ms, loss 5 %, delays that change 300 ms\""));
  EXPECT_THAT(csv, HasSubstr(",1.2 kg 5 N s/m + left,"));
}

}  // namespace
}  // namespace tandem
