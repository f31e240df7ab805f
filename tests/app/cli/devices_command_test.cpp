// Tests `tandem devices`: which devices are there, what is missing, and what mends it.
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "tests/app/cli/program_run.h"

namespace tandem {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramOutput;
using testing::RunTandem;

json DeviceNamed(const json& output, const std::string& name) {
  for (const json& device : output.at("devices")) {
    if (device.at("name") == name) return device;
  }
  return {};
}

TEST(DevicesCommand, ListsEachDriverWithItsRemedy) {
  const ProgramOutput output = RunTandem("devices --json");
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json out = json::parse(output.out, nullptr, false);
  ASSERT_TRUE(out.is_object()) << output.out;
  for (const std::string name : {"scripted", "none", "recorded"}) {
    const json device = DeviceNamed(out, name);
    ASSERT_TRUE(device.is_object()) << name;
    EXPECT_EQ(device.at("present"), true);
    EXPECT_EQ(device.at("missing"), "");
  }
  for (const json& device : out.at("devices")) {
    EXPECT_NE(device.at("kind"), "");
    // a missing thing has a line that mends it
    EXPECT_EQ(device.at("missing") == "", device.at("mend") == "") << device;
    EXPECT_NE(device.at("name"), "fake");
  }
  EXPECT_THAT(RunTandem("devices").out, HasSubstr("scripted"));
  EXPECT_THAT(RunTandem("devices --all").out, HasSubstr("fake"));
}

TEST(DevicesCommand, SurvivesACrashingDriverAndReportsInvalidClaims) {
  setenv("TANDEM_DEVICES", TANDEM_UNSOUND_DRIVERS, 1);
  const ProgramOutput output = RunTandem("devices --json");
  unsetenv("TANDEM_DEVICES");
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json out = json::parse(output.out, nullptr, false);
  ASSERT_TRUE(out.is_object()) << output.out;
  EXPECT_THAT(DeviceNamed(out, "crashing").at("missing").get<std::string>(),
              HasSubstr("ended with exit code 134"));
  EXPECT_THAT(DeviceNamed(out, "newer").at("missing").get<std::string>(),
              HasSubstr("built for version 2"));
  EXPECT_EQ(DeviceNamed(out, "scripted").at("present"), true);
}

TEST(DevicesCommand, TriesADeviceWithoutForce) {
  const ProgramOutput output =
      RunTandem("devices --try fake:z_mm=5,fail_at=600 --seconds 0.8 --json");
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const json out = json::parse(output.out, nullptr, false);
  ASSERT_TRUE(out.is_object()) << output.out;
  EXPECT_EQ(out.at("device"), "fake:z_mm=5,fail_at=600");
  EXPECT_EQ(out.at("ticks"), 800);
  EXPECT_NEAR(out.at("moved_mm").get<double>(), 5, 1e-6);
  EXPECT_EQ(out.at("failed"), 50);
  EXPECT_THAT(out.at("troubles").at(0).get<std::string>(),
              HasSubstr("the driver was asked to fail"));
  EXPECT_EQ(out.at("allocations"), 0);
  EXPECT_GT(out.at("read_us").at("p99").get<double>(), 0);

  const ProgramOutput none = RunTandem("devices --try omega --seconds 0.1");
  EXPECT_EQ(none.exit_code, kExitDevice);
  EXPECT_THAT(none.err, HasSubstr("there is no driver 'omega'"));
}

}  // namespace
}  // namespace tandem
