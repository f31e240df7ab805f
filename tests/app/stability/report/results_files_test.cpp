#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "app/stability/report/data_files.h"
#include "app/stability/report/seed_spread.h"
#include "collab/lab/metrics/series_file.h"
#include "tests/app/stability/report/made_results.h"

namespace tandem {
namespace {

using ::testing::ElementsAreArray;

/// Returns the first column of the table below a heading of docs/results-files.md, without
/// backticks.
std::vector<std::string> DocumentedColumns(const std::string& heading) {
  std::ifstream document(TANDEM_SOURCE_DIR "/docs/results-files.md");
  std::vector<std::string> columns;
  bool below = false;
  for (std::string line; std::getline(document, line);) {
    if (line.starts_with("## ")) below = line == "## " + heading;
    if (!below || !line.starts_with("| `")) continue;
    columns.push_back(line.substr(3, line.find('`', 3) - 3));
  }
  return columns;
}

std::vector<std::string> NamesIn(const std::string& csv) {
  std::istringstream names(csv.substr(0, csv.find('\n')));
  std::vector<std::string> out;
  for (std::string name; std::getline(names, name, ',');) out.push_back(name);
  return out;
}

TEST(ResultsFiles, DocumentTheColumnsOfCellsInTheirOrder) {
  EXPECT_THAT(NamesIn(CsvOf(testing::TwentyCells())), ElementsAreArray(DocumentedColumns("Cells")));
}

TEST(ResultsFiles, DocumentTheColumnsOfACourseInTheirOrder) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("tandem-course-" + std::to_string(getpid()) + ".csv");
  Result<SeriesFile> series = SeriesFile::Create(file, 2, 1);
  ASSERT_TRUE(series);
  ASSERT_FALSE(series->Close());
  std::string header;
  std::getline(std::ifstream(file) >> std::ws, header);
  std::filesystem::remove(file);
  std::vector<std::string> expected;
  std::vector<std::string> of_user;
  for (const std::string& column : DocumentedColumns("Course in time")) {
    (column.find('@') == std::string::npos ? expected : of_user).push_back(column);
  }
  for (const char* user : {"1", "2"}) {
    for (std::string column : of_user) {
      column.replace(column.find('@'), 1, user);
      expected.push_back(column);
    }
  }
  EXPECT_THAT(NamesIn(header), ElementsAreArray(expected));
}

TEST(ResultsFiles, DocumentTheColumnsOfTheSpreadOverSeedsInTheirOrder) {
  Results results = testing::TwentyCells();
  CellRecord again = results.records.at(6);
  again.cell.number = 20;
  testing::ReplaceInCase(again, "\"seed\":7", "\"seed\":8");
  results.records.emplace(20, again);
  const std::optional<ReportTable> spread = SeedSpreadOf(results);
  ASSERT_TRUE(spread);
  EXPECT_THAT(spread->columns, ElementsAreArray(DocumentedColumns("Spread over seeds")));
}

// One case runs with two seeds: in a clean network with the same figures, then with others, then in
// a network with jitter.
TEST(SeedSpread, CountsCasesAlikeForAllSeeds) {
  Results results = testing::TwentyCells();
  EXPECT_EQ(CountCasesAlikeForAllSeeds(results), 0U) << "one seed each";
  CellRecord again = results.records.at(6);
  again.cell.number = 20;
  testing::ReplaceInCase(again, "\"seed\":7", "\"seed\":8");
  results.records.emplace(20, again);
  EXPECT_EQ(CountCasesAlikeForAllSeeds(results), 1U);
  results.records.at(20).outcome.result.metrics.peak_apart += 1e-9;
  EXPECT_EQ(CountCasesAlikeForAllSeeds(results), 0U) << "other figures";
  results.records.insert_or_assign(20, again);
  for (const std::size_t cell : {6U, 20U}) {
    testing::ReplaceInCase(results.records.at(cell), R"("network":"clean")",
                           R"("network":"lossy")");
  }
  EXPECT_EQ(CountCasesAlikeForAllSeeds(results), 0U) << "alike by chance";
}

// pandas takes other spellings too, R does not.
TEST(ResultsFiles, UseBooleanValuesReadableByR) {
  const std::string csv = CsvOf(testing::TwentyCells());
  const std::vector<std::string> names = NamesIn(csv);
  const auto gate = std::ranges::find(names, "gate") - names.begin();
  const auto diverged = std::ranges::find(names, "blew_up") - names.begin();
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  int blown = 0;
  while (std::getline(lines, line)) {
    const std::vector<std::string> values = NamesIn(line);
    EXPECT_EQ(values.at(static_cast<std::size_t>(gate)), "FALSE");
    const std::string& value = values.at(static_cast<std::size_t>(diverged));
    EXPECT_TRUE(value == "TRUE" || value == "FALSE") << value;
    blown += value == "TRUE" ? 1 : 0;
  }
  EXPECT_EQ(blown, 5);
}

}  // namespace
}  // namespace tandem
