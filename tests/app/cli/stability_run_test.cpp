#include <algorithm>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "app/exit_codes.h"
#include "tests/app/cli/program_run.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::RunTandem;
using testing::Said;

Said RunFile(const ScratchFolder& folder, const std::string& text,
             const std::string& options = "") {
  folder.Write("case.json", text);
  return RunTandem("stability run " + (folder.path() / "case.json").string() + " " + options);
}

TEST(StabilityRun, TellsAllThatIsMeasuredAndWritesItsCourse) {
  const ScratchFolder folder;
  const std::string csv = (folder.path() / "course.csv").string();
  const Said said = RunFile(folder, R"({"name": "knock", "law": {"name": "p+d", "gate": false}})",
                            "--json --series " + csv + " --every-ms 10");
  ASSERT_EQ(said.exit_code, kExitOk) << said.err;
  const auto out = nlohmann::json::parse(said.out);
  EXPECT_EQ(out["name"], "knock");
  EXPECT_EQ(out["verdict"], "stable");
  EXPECT_EQ(out["predicted"]["stable"], true);
  EXPECT_LT(out["metrics"]["growth"], 0.0);
  EXPECT_EQ(out["metrics"]["frames"], 12000);
  EXPECT_GT(out["speed"], 0.0);
  std::ifstream course(csv);
  std::string line;
  std::getline(course, line);
  EXPECT_THAT(line, HasSubstr("t_s,apart_mm,x1_mm,"));
  const auto columns = std::count(line.begin(), line.end(), ',');
  EXPECT_EQ(columns, 1 + 2 * 11);
  int lines = 0;
  double farthest_mm = 0;
  while (std::getline(course, line)) {
    ++lines;
    ASSERT_EQ(std::count(line.begin(), line.end(), ','), columns);
    farthest_mm = std::max(farthest_mm, std::stod(line.substr(line.find(',') + 1)));
  }
  EXPECT_EQ(lines, 1200);
  EXPECT_NEAR(farthest_mm, 1e3 * out["metrics"]["peak_apart"].get<double>(), 0.1);
}

// So that a script that tries one's own gains can go by it.
TEST(StabilityRun, EndsWithOneWhereACaseIsUnstable) {
  const ScratchFolder folder;
  const Said said =
      RunFile(folder, R"({"hands": ["off"], "law": {"name": "constant", "gate": false}})");
  EXPECT_EQ(said.exit_code, kExitFailed);
  EXPECT_THAT(said.out, HasSubstr("case: unstable"));
}

TEST(StabilityRun, AFaultyCaseIsOneLine) {
  const ScratchFolder folder;
  const Said said = RunFile(folder, R"({"hand": ["off"]})");
  EXPECT_EQ(said.exit_code, kExitFile);
  EXPECT_THAT(said.err, HasSubstr("case.json: hand: unknown key; did you mean hands?\n"));
  EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1);
  const Said scene = RunFile(folder, R"({"scene": "nowhere.json"})");
  EXPECT_EQ(scene.exit_code, kExitFile);
  EXPECT_THAT(scene.err, HasSubstr("nowhere.json"));
}

// The paper's linear law: 40 N/m with 10 N s/m of drag at every delay to 1 s, 200 N/m without drag
// at none.
TEST(StabilityRun, ThePapersLawHoldsWhereItIsSoftAndIsCaughtWhereItIsNot) {
  const ScratchFolder folder;
  const Said said = RunTandem("stability sweep " TANDEM_SCENES "/stability/paper.json --json");
  ASSERT_EQ(said.exit_code, kExitOk) << said.out << said.err;
  const auto out = nlohmann::json::parse(said.out);
  EXPECT_EQ(out["cells"], 26);
  EXPECT_EQ(out["positive_controls_caught"], 2);
}

}  // namespace
}  // namespace tandem
