#include <algorithm>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"

namespace tandem {
namespace {

using testing::ProgramOutput;
using testing::RunTandem;

// four cells of the default law, in free space and at a wall, and a control
constexpr const char* kSweep = R"({"name": "five", "blocks": [
    {"expect": "stable", "scene": ["free", "wall"], "hands": "heavy", "delay_s": [0.02, 0.1],
     "law": {"gate": false}},
    {"expect": "unstable", "hands": "off",
     "law": {"name": "constant", "gate": false,
             "limits": {"constant_stiffness": 200, "constant_damping": 0}}}]})";

ProgramOutput RunSweep(const ScratchFolder& folder, const std::string& arguments) {
  return RunTandem("stability sweep " + (folder.path() / "five.json").string() + " " + arguments);
}

std::string ContentOf(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

TEST(StabilitySweep, ResultIsIndependentOfJobsAndShards) {
  const ScratchFolder folder;
  folder.Write("five.json", kSweep);
  const auto out = [&folder](const char* name) {
    return " --out " + (folder.path() / name).string();
  };
  const ProgramOutput one = RunSweep(folder, "--jobs 1 --json" + out("one"));
  ASSERT_EQ(one.exit_code, kExitOk) << one.out << one.err;
  const auto summary = nlohmann::json::parse(one.out);
  EXPECT_EQ(summary["cells"], 5);
  EXPECT_EQ(summary["jobs"], 1);
  EXPECT_EQ(summary["default_law_cells"], 4);
  EXPECT_EQ(summary["default_law_unstable"], 0);
  EXPECT_EQ(summary["positive_controls_caught"], 1);
  EXPECT_GT(summary["max_tail_rms_mm_s"], 0.0);
  EXPECT_EQ(nlohmann::json::parse(ContentOf(folder.path() / "one" / "summary.json")), summary);

  const ProgramOutput three = RunSweep(folder, "--jobs 3 --json");
  EXPECT_EQ(nlohmann::json::parse(three.out)["digest"], summary["digest"]);

  EXPECT_EQ(RunSweep(folder, "--shard 1/2" + out("a")).exit_code, kExitOk);
  EXPECT_EQ(RunSweep(folder, "--shard 2/2" + out("b")).exit_code, kExitOk);
  const auto path = [&folder](const char* name) {
    return (folder.path() / name).string() + " ";
  };
  const ProgramOutput merged =
      RunTandem("stability merge --json " + path("a") + path("b") + out("merged"));
  ASSERT_EQ(merged.exit_code, kExitOk) << merged.err;
  EXPECT_EQ(nlohmann::json::parse(merged.out)["digest"], summary["digest"]);
  EXPECT_EQ(nlohmann::json::parse(merged.out)["rows"], summary["rows"]);

  // merging one shard alone names the missing cells
  const ProgramOutput part = RunTandem("stability merge " + path("b"));
  EXPECT_EQ(part.exit_code, kExitFailed);
  EXPECT_NE(part.err.find("3 of 5 cells are missing: "), std::string::npos) << part.err;

  // all cells are there: nothing is run
  const ProgramOutput again = RunSweep(folder, "--json" + out("one"));
  EXPECT_NE(again.err.find("5 cells are done already"), std::string::npos) << again.err;
  EXPECT_EQ(nlohmann::json::parse(again.out)["digest"], summary["digest"]);
  // the finished log is not taken for a shard's
  EXPECT_EQ(RunSweep(folder, "--shard 1/2" + out("one")).exit_code, kExitFile);
}

TEST(StabilitySweep, PrintsACaseThatRunsToTheSameDigest) {
  const ScratchFolder folder;
  folder.Write("five.json", kSweep);
  const ProgramOutput printed = RunSweep(folder, "--print 1");
  ASSERT_EQ(printed.exit_code, kExitOk) << printed.err;
  const auto file = folder.Write("case.json", printed.out);
  const ProgramOutput alone = RunTandem("stability run --json " + file.string());
  ASSERT_EQ(alone.exit_code, kExitOk) << alone.err;
  ASSERT_EQ(RunSweep(folder, "--out " + (folder.path() / "all").string()).exit_code, kExitOk);
  std::istringstream cells(ContentOf(folder.path() / "all" / "cells.jsonl"));
  std::string line;
  for (int i = 0; i < 3; ++i) std::getline(cells, line);  // the header, cells 0 and 1
  const auto cell = nlohmann::json::parse(line);
  EXPECT_EQ(cell["cell"], 1);
  EXPECT_EQ(cell["digest"], nlohmann::json::parse(alone.out)["digest"]);
  EXPECT_EQ(cell["metrics"], nlohmann::json::parse(alone.out)["metrics"]);
}

TEST(StabilitySweep, FailedRowExitsWithOneAndNamesItsCells) {
  const ScratchFolder folder;
  // the control is stable, so it is none
  folder.Write("five.json",
               R"({"name": "tame", "blocks": [{"expect": "unstable", "delay_s": 0.02}]})");
  const ProgramOutput output = RunSweep(folder, "");
  EXPECT_EQ(output.exit_code, kExitFailed);
  EXPECT_NE(output.out.find("FAIL  controls reported unstable"), std::string::npos) << output.out;
  EXPECT_NE(output.out.find("cell 0: stable"), std::string::npos) << output.out;
}

TEST(StabilitySweep, ReportsErrorsInOneLine) {
  const ScratchFolder folder;
  folder.Write("five.json", R"({"name": "s", "blocks": [{"hands": ["off", "hevy"]}]})");
  const ProgramOutput output = RunSweep(folder, "");
  EXPECT_EQ(output.exit_code, kExitFile);
  EXPECT_NE(output.err.find("five.json: blocks[0].hands[1]: hands[0]: no hand of the lab is called "
                            "'hevy'"),
            std::string::npos)
      << output.err;
  EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
  folder.Write("five.json", kSweep);
  EXPECT_EQ(RunSweep(folder, "--shard 3/2").exit_code, kExitUsage);
  EXPECT_EQ(RunSweep(folder, "--print 5").exit_code, kExitUsage);
  EXPECT_EQ(RunTandem("stability sweep none.json").exit_code, kExitFile);
  EXPECT_EQ(RunTandem("stability merge none.jsonl").exit_code, kExitFailed);
}

}  // namespace
}  // namespace tandem
