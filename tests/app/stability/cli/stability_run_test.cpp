#include <algorithm>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"

namespace tandem {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

ProgramOutput RunFile(const ScratchFolder& folder, const std::string& text,
                      const std::string& options = "") {
  folder.Write("case.json", text);
  return RunTandem("stability run " + (folder.path() / "case.json").string() + " " + options);
}

TEST(StabilityRun, ReportsAllMetricsAndWritesTheSeries) {
  const ScratchFolder folder;
  const std::string csv = (folder.path() / "course.csv").string();
  const ProgramOutput output =
      RunFile(folder, R"({"name": "knock", "law": {"name": "p+d", "gate": false}})",
              "--json --series " + csv + " --every-ms 10");
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const auto out = nlohmann::json::parse(output.out);
  EXPECT_EQ(out["name"], "knock");
  EXPECT_EQ(out["verdict"], "stable");
  EXPECT_EQ(out["predicted"]["stable"], true);
  EXPECT_EQ(out["predicted"]["covers"], "six axes");
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

// A script that tries a user's own gains can go by the exit code.
TEST(StabilityRun, UnstableCaseExitsWithOne) {
  const ScratchFolder folder;
  const ProgramOutput output =
      RunFile(folder, R"({"hands": ["off"], "law": {"name": "constant", "gate": false}})");
  EXPECT_EQ(output.exit_code, kExitFailed);
  EXPECT_THAT(output.out, HasSubstr("case: unstable"));
  // docs/stability.md, section 1: it blows up before a growth can be told
  EXPECT_THAT(output.out, ContainsRegex("  ended +[0-9.]+ s after the loops closed, 0.5 m apart"));
  EXPECT_THAT(output.out, HasSubstr("  growth            not measured: the run ended too early"));
}

/// Returns the `number`th part of a document that is fenced as code.
std::string FencedIn(const std::string& document, int number) {
  std::ostringstream text;
  text << std::ifstream(document).rdbuf();
  std::string rest = text.str();
  for (int fence = 0; fence < 2 * number + 1; ++fence) rest = rest.substr(rest.find("```") + 3);
  rest = rest.substr(rest.find('\n') + 1);
  return rest.substr(0, rest.find("```"));
}

TEST(StabilityRun, GuidesExampleWorks) {
  const std::string guide = TANDEM_SOURCE_DIR "/docs/stability.md";
  const ScratchFolder folder;
  const ProgramOutput output = RunFile(folder, FencedIn(guide, 1));
  EXPECT_EQ(output.exit_code, kExitFailed);
  std::istringstream shown(FencedIn(guide, 2));
  int lines = 0;
  for (std::string line; std::getline(shown, line);) {
    if (line == "  ...") continue;
    ++lines;
    EXPECT_THAT(output.out, HasSubstr(line + "\n"));
  }
  EXPECT_EQ(lines, 9);
}

// 120 N/m among three are 60 N/m a link.
TEST(StabilityRun, DistinguishesLinkFromUserStiffness) {
  const ScratchFolder folder;
  const ProgramOutput output = RunFile(folder, R"({"users": 3, "hands": ["heavy"], "delay_s": 0.1,
      "law": {"name": "constant", "gate": false,
              "limits": {"constant_stiffness": 60, "constant_damping": 10}}})");
  EXPECT_EQ(output.exit_code, kExitOk) << output.out;
  EXPECT_THAT(output.out, HasSubstr("30.0 N/m of a link at the end"));
  EXPECT_THAT(output.out, HasSubstr("60.0 N/m of all links of a user"));
}

// The case's own length is 12 s, after which it swings by 2.2 mm/s and falls by a third a second.
TEST(StabilityRun, ContinuesAnUnsettledDecay) {
  const ScratchFolder folder;
  const std::string text = R"("users": 3, "hands": ["heavy"], "delay_s": 0.2,
      "network": {"jitter_ms": 20, "loss": 0.05},
      "law": {"name": "constant", "gate": false,
              "limits": {"constant_stiffness": 120, "constant_damping": 6}}})";
  const ProgramOutput output = RunFile(folder, "{" + text);
  EXPECT_EQ(output.exit_code, kExitOk) << output.out;
  EXPECT_THAT(output.out, HasSubstr("case: stable"));
  EXPECT_THAT(output.out,
              ContainsRegex("  extended +[0-9.]+ s instead of 12.00 s, because it decayed"));
  // a case that gives its length is not made longer
  const ProgramOutput early = RunFile(folder, R"({"seconds": 12, )" + text);
  EXPECT_EQ(early.exit_code, kExitFailed);
  EXPECT_THAT(early.out, HasSubstr("case: undecided"));
  EXPECT_THAT(early.out, HasSubstr("it decays but is not at rest: give the case more seconds"));
}

TEST(StabilityRun, InvalidCaseIsReportedInOneLine) {
  const ScratchFolder folder;
  const ProgramOutput output = RunFile(folder, R"({"hand": ["off"]})");
  EXPECT_EQ(output.exit_code, kExitFile);
  EXPECT_THAT(output.err, HasSubstr("case.json: hand: unknown key; did you mean hands?\n"));
  EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1);
  const ProgramOutput scene = RunFile(folder, R"({"scene": "nowhere.json"})");
  EXPECT_EQ(scene.exit_code, kExitFile);
  EXPECT_THAT(scene.err, HasSubstr("nowhere.json"));
}

// The paper's linear law holds with 40 N/m and 10 N s/m of drag at every delay to 1 s. With 200 N/m
// and no drag it holds at none.
TEST(StabilityRun, PapersLawIsStableWhenSoftAndElseDetectedUnstable) {
  const ScratchFolder folder;
  const ProgramOutput output =
      RunTandem("stability sweep " TANDEM_SCENES "/stability/paper.json --json");
  ASSERT_EQ(output.exit_code, kExitOk) << output.out << output.err;
  const auto out = nlohmann::json::parse(output.out);
  EXPECT_EQ(out["cells"], 26);
  EXPECT_EQ(out["positive_controls_caught"], 2);
}

TEST(StabilityRun, UnusedGainsAreRefusedByAPeerToo) {
  const ProgramOutput output = RunTandem(
      "peer --session gains --scene peg_in_slot --lab --law p+d --gain constant_stiffness=80");
  EXPECT_EQ(output.exit_code, kExitUsage);
  EXPECT_THAT(output.err, HasSubstr("--gain constant_stiffness: the law 'p+d' does not use it: it "
                                    "uses damping_budget, stiffness, margin and ratio"));
}

// 10 ms of jitter in the mean and lost samples age what is applied. So the boundary lies lower than
// on a clean line, for which theory gives it.
TEST(StabilityRandom, JudgesRandomCasesAndPrintsAnyOfThem) {
  const ProgramOutput output = RunTandem("stability random --seeds 2 --first 5 --jobs 2 --json");
  ASSERT_EQ(output.exit_code, kExitOk) << output.out << output.err;
  const auto out = nlohmann::json::parse(output.out);
  EXPECT_EQ(out["cells"], 2);
  EXPECT_EQ(out["not_stable"], 0);
  EXPECT_EQ(out["predicted_stable_measured_unstable"], 0);
  EXPECT_LE(out["max_energy_mJ"], 1);
  EXPECT_LT(out["max_tail_rms_mm_s"], 0.5);
  EXPECT_TRUE(out["worst"].empty());
  // the result is the same whatever runs beside it
  const auto alone =
      nlohmann::json::parse(RunTandem("stability random --seeds 2 --first 5 --jobs 1 --json").out);
  EXPECT_EQ(alone["digest"], out["digest"]);
  const ScratchFolder folder;
  const ProgramOutput printed = RunTandem("stability random --print 5");
  const ProgramOutput run = RunFile(folder, printed.out, "--json");
  EXPECT_EQ(run.exit_code, kExitOk) << run.err;
  EXPECT_EQ(nlohmann::json::parse(run.out)["name"], "random 5");
}

TEST(StabilityBoundary, AcceptsJitterLossAndSeeds) {
  const std::string options = " --hands off --delays 0.1 --seconds 30 --publish-hz 100 --json";
  const ProgramOutput clean = RunTandem("stability boundary" + options);
  ASSERT_EQ(clean.exit_code, kExitOk) << clean.out << clean.err;
  const ProgramOutput lossy =
      RunTandem("stability boundary --jitter-ms 40 --loss 0.1 --seeds 1,2" + options);
  ASSERT_EQ(lossy.exit_code, kExitOk) << lossy.out << lossy.err;
  const auto one = nlohmann::json::parse(clean.out)["boundary"];
  const auto two = nlohmann::json::parse(lossy.out)["boundary"];
  ASSERT_EQ(one.size(), 1U);
  ASSERT_EQ(two.size(), 2U);
  EXPECT_EQ(one[0]["network"], "clean");
  EXPECT_EQ(two[1]["network"], "jitter 40 ms, loss 10 %");
  EXPECT_EQ(two[1]["seed"], 2);
  EXPECT_EQ(two[1]["judged"], false);
  EXPECT_NE(two[0]["measured_N_m"], two[1]["measured_N_m"]);
  for (const auto& row : two) {
    EXPECT_LT(row["predicted_N_m"], one[0]["predicted_N_m"]);
    EXPECT_LT(row["measured_N_m"], one[0]["measured_N_m"]);
    EXPECT_GT(row["ratio"], 0.9);
  }
}

}  // namespace
}  // namespace tandem
