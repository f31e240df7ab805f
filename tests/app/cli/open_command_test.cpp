#include <cstdlib>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/app/cli/program_run.h"

// Tests `tandem open` and `tandem join` as far as they need no display.

namespace tandem {
namespace {

using testing::ProgramOutput;
using testing::RunTandem;

TEST(OpenCommand, DryRunDescribesTheWindowAndEndsItsController) {
  const ProgramOutput output = RunTandem(
      "open peg_in_slot --headless --json --name anna --peer-options "
      "'--capacity 20000'");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const nlohmann::json shown = nlohmann::json::parse(output.out);
  EXPECT_GT(shown.at("frame").get<int>(), 0);
  EXPECT_EQ(shown.at("bodies").size(), 2U);
  EXPECT_EQ(shown.at("hand").at("state"), "empty");
  EXPECT_EQ(shown.at("hand").at("body"), nullptr);
  EXPECT_EQ(shown.at("safety").at("stops"), 0);
  EXPECT_NE(shown.at("scene").get<std::string>().find("peg_in_slot.json"), std::string::npos);
  // its controller is gone: nobody runs with its name any more
  const std::string control = shown.at("controller");
  EXPECT_NE(std::system(("pgrep -f -- '[-]-control " + control + "' >/dev/null").c_str()), 0);
}

TEST(OpenCommand, DeviceReplacesTheMouse) {
  const ProgramOutput output = RunTandem("open peg_in_slot --headless --json --device fake:x_mm=5");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  EXPECT_EQ(nlohmann::json::parse(output.out).at("hand").at("input"), "device");
  EXPECT_EQ(RunTandem("open peg_in_slot --headless --device no-such:").exit_code, 6);
}

TEST(OpenCommand, ReportsErrorsInOneLineWithExitCodes) {
  ProgramOutput output = RunTandem("open no_such_scene --headless");
  EXPECT_EQ(output.exit_code, 3);
  EXPECT_NE(output.err.find("no_such_scene"), std::string::npos);
  output = RunTandem("open peg_in_slot --json");
  EXPECT_EQ(output.exit_code, 2);
  output = RunTandem("join");
  EXPECT_EQ(output.exit_code, 2);
  output = RunTandem("join S --role boss");
  EXPECT_EQ(output.exit_code, 2);
  output = RunTandem("join S --scene no_such_scene");
  EXPECT_EQ(output.exit_code, 3);
}

}  // namespace
}  // namespace tandem
