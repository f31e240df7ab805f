#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

constexpr const char* kReportedSweep = R"({"name": "six", "blocks": [
    {"hands": "heavy", "delay_s": [0.05, 0.1],
     "law": {"name": "constant", "gate": false, "limits": {"constant_damping": 10}},
     "stiffness_N_m": [40, 80, 400]}]})";

std::string ReportContent(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

TEST(StabilityReport, SweepReportHasItsMapAndReproducibleCells) {
  const ScratchFolder folder;
  const std::string sweep = folder.Write("six.json", kReportedSweep).string();
  const std::filesystem::path out = folder.path() / "report";
  const ProgramOutput output =
      RunTandem("stability sweep " + sweep + " --json --report " + out.string());
  ASSERT_EQ(nlohmann::json::parse(output.out)["cells"], 6) << output.err;
  EXPECT_THAT(output.err, HasSubstr("report.html"));
  const auto report = nlohmann::json::parse(ReportContent(out / "report.json"));
  EXPECT_EQ(report["sweeps"][0]["cells"].size(), 6U);
  bool compared = false;
  for (const auto& row : report["rows"]) {
    if (row["name"] != "cells run again with the same digest") continue;
    compared = true;
    EXPECT_TRUE(row["pass"]);
    EXPECT_GE(row["value"], 2);
  }
  EXPECT_TRUE(compared);
  EXPECT_THAT(ReportContent(out / "report.html"), HasSubstr("exact boundary"));
  EXPECT_THAT(ReportContent(out / "pictures" / "six-map-1.svg"),
              HasSubstr("paper&#39;s linear law"));
  for (const auto& one : report["series"]) {
    EXPECT_TRUE(std::filesystem::exists(out / one["csv"].get<std::string>()));
  }
  // the same results give the same page
  const ProgramOutput again = RunTandem("stability report " + out.string() + " --series 0 --out " +
                                        (folder.path() / "again").string());
  EXPECT_EQ(again.exit_code, kExitOk) << again.err;
  EXPECT_EQ(ReportContent(folder.path() / "again" / "six-cells.csv"),
            ReportContent(out / "six-cells.csv"));
}

TEST(StabilityReport, ReportsInvalidInput) {
  const ScratchFolder folder;
  const std::string file = folder.Write("a.json", "[1]").string();
  const std::string out = " --out " + (folder.path() / "out").string();
  const ProgramOutput output = RunTandem("stability report " + file + out);
  EXPECT_EQ(output.exit_code, kExitFile);
  EXPECT_THAT(output.err, HasSubstr("a.json: is neither"));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
  EXPECT_EQ(RunTandem("stability report " + out).exit_code, kExitUsage);
}

}  // namespace
}  // namespace tandem
