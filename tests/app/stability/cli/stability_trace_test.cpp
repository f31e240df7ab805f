#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

std::string FirstLine(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

TEST(StabilityTrace, ServesAsTheNetworkOfACaseOrSweep) {
  const ScratchFolder folder;
  const std::string path = folder.path().string();
  const ProgramOutput made =
      RunTandem("stability trace lte --out " + path + "/lte.csv --seconds 20 --json");
  ASSERT_EQ(made.exit_code, kExitOk) << made.err;
  EXPECT_EQ(nlohmann::json::parse(made.out)["there"]["samples"], 20'000);
  EXPECT_THAT(FirstLine(folder.path() / "lte.csv"), HasSubstr("\"tandem_trace\":1"));

  folder.Write("case.json", R"({"network": {"trace": "lte.csv", "stretch": 1.5}, "seconds": 4})");
  const ProgramOutput run = RunTandem("stability run " + path + "/case.json --json");
  ASSERT_EQ(run.exit_code, kExitOk) << run.err;
  const auto result = nlohmann::json::parse(run.out);
  EXPECT_EQ(result["predicted"]["stable"], true);
  EXPECT_EQ(
      nlohmann::json::parse(RunTandem("stability run " + path + "/case.json --json").out)["digest"],
      result["digest"]);

  folder.Write("sweep.json", R"({"name": "s", "blocks": [{"expect": "stable", "seconds": 4,
      "network": [{"trace": "lte.csv", "stretch": 1.5}, "lossy"]}]})");
  const ProgramOutput sweep = RunTandem("stability sweep " + path + "/sweep.json --json");
  EXPECT_EQ(sweep.exit_code, kExitOk) << sweep.out << sweep.err;
  // with the trace only its delays count; the network without a trace has the default delay
  EXPECT_THAT(RunTandem("stability sweep " + path + "/sweep.json --print 0").out,
              HasSubstr("\"delay_s\":0,"));
  EXPECT_THAT(RunTandem("stability sweep " + path + "/sweep.json --print 1").out,
              HasSubstr("\"delay_s\":0.1,"));
}

TEST(StabilityTrace, RefusesImpossibleModelsAndUnwritableFiles) {
  const ProgramOutput unknown = RunTandem("stability trace 6g --out /tmp/none.csv");
  EXPECT_EQ(unknown.exit_code, kExitUsage);
  EXPECT_THAT(unknown.err, HasSubstr("there are wifi, lte"));
  EXPECT_EQ(RunTandem("stability trace lte --out /nowhere/none.csv").exit_code, kExitFile);
  const ProgramOutput missing = RunTandem("stability trace lte");
  EXPECT_THAT(missing.err, HasSubstr("--out"));
}

}  // namespace
}  // namespace tandem
