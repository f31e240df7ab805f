// Tests `tandem peer --device` as a person uses it: the device is in a process of its own.
#include <csignal>
#include <cstring>
#include <fstream>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/mman.h>

#include "app/common/exit_codes.h"
#include "app/device/drivers/fake/fake_record.h"
#include "tests/app/cli/peer_program.h"

namespace tandem {
namespace {

using nlohmann::json;
using testing::ExpectRefused;
using ::testing::HasSubstr;
using testing::PeerCommand;
using testing::ProgramOutput;
using testing::Running;

class DeviceCommand : public PeerCommand {
 protected:
  /// Returns the options of a peer whose hand swings the right box by 10 mm, three times a second.
  std::string Swinging(const std::string& more) const {
    return "--name anna --hold right --device fake:record=" + In("motor") +
           ",swing_mm=10,swing_hz=3 " + more;
  }
  json Report() const {
    std::ifstream stream(In("report"));
    return json::parse(stream, nullptr, false);
  }
  /// Returns the force at the motor in each of the last `last` writes.
  std::vector<double> Forces(std::size_t last) const {
    std::ifstream stream(In("motor"), std::ios::binary);
    auto record = std::make_unique<FakeRecord>();
    stream.read(reinterpret_cast<char*>(record.get()), sizeof *record);
    const std::uint64_t count = record->count.load();
    std::vector<double> forces;
    for (std::uint64_t i = count - std::min<std::uint64_t>(last, count); i < count; ++i) {
      const auto& f = record->writes[i % FakeRecord::kRoom].force_N;
      forces.push_back(std::hypot(f[0], f[1], f[2]));
    }
    return forces;
  }
  /// Returns whether a force of 0.1 N is at the motor within ten seconds.
  bool WaitForForce() const {
    constexpr std::size_t kNewest = 100;  // writes: none from before a stop
    for (int i = 0; i < 500; ++i) {
      const std::vector<double> forces = Forces(kNewest);
      if (!forces.empty() && *std::max_element(forces.begin(), forces.end()) > 0.1) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }
  /// Returns the device process of the peer that runs.
  pid_t DevicePid() const {
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      std::ifstream stream(entry.path() / "cmdline", std::ios::binary);
      const std::string words{std::istreambuf_iterator<char>(stream), {}};
      if (words.find("tandem-device") != std::string::npos &&
          words.find(std::string("fake:record=") + In("motor")) != std::string::npos &&
          words.find("--memory") != std::string::npos) {
        return std::stoi(entry.path().filename());
      }
    }
    return -1;
  }
};

TEST_F(DeviceCommand, DeviceProcessGivesForceAndIsReported) {
  const ProgramOutput output = Run("one", Swinging("--seconds 3 --report " + In("report")));
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_THAT(output.err, HasSubstr("at most 3 N and 0.15 N m"));
  const json report = Report();
  EXPECT_THAT(report.at("device").get<std::string>(), HasSubstr("fake:record="));
  const json& safety = report.at("safety");
  for (const char* count : {"clamped", "slewed", "zeroed", "expired", "stops"}) {
    EXPECT_TRUE(safety.at(count).is_number_unsigned()) << count;
  }
  EXPECT_EQ(safety.at("stops"), 0);
  EXPECT_TRUE(safety.at("state").is_string());
  EXPECT_EQ(safety.at("passivity").at("control"), false);
  EXPECT_TRUE(safety.at("passivity").at("balance_J").is_number());
  EXPECT_THAT(report.at("device_times").at("scheduler").get<std::string>(), HasSubstr("SCHED_"));
  EXPECT_TRUE(report.at("device_times").at("unanswered_share").is_number());
  EXPECT_GT(report.at("device_times").at("answered").get<int>(), 1000);
  // 0.1 kg swung by 10 mm three times a second takes 0.36 N
  const std::vector<double> forces = Forces(3000);
  const double most = *std::max_element(forces.begin(), forces.end());
  EXPECT_GT(most, 0.1);
  EXPECT_LE(most, 3.0);
  EXPECT_EQ(forces.back(), 0);
}

TEST_F(DeviceCommand, ReportsImpossibleDeviceClaims) {
  const ProgramOutput output =
      Run("one",
          "--name anna --hold right --passivity --device-core 1023 --device "
          "fake:continuous_N=-1,stiffness=nan,rate_hz=30 --seconds 1 --report " +
              In("report"));
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_THAT(output.err, HasSubstr("for ever: a force of -1 N is no limit: it counts as zero"));
  EXPECT_THAT(output.err, HasSubstr("a stiffness of nan N/m is none: it counts as zero"));
  EXPECT_THAT(output.err, HasSubstr("its 30 Hz are too slow for the limits on old forces"));
  EXPECT_THAT(output.err, HasSubstr("device process: "));
  EXPECT_THAT(output.err, HasSubstr("core 1023 cannot be had"));
  EXPECT_EQ(Report().at("safety").at("passivity").at("control"), true);
}

TEST_F(DeviceCommand, PeerSurvivesItsDevice) {
  Running anna = Start("one", Swinging("--report " + In("report")));
  ASSERT_TRUE(anna.WaitFor("anna is in session"));
  const pid_t device = DevicePid();
  ASSERT_GT(device, 0);
  kill(device, SIGKILL);
  EXPECT_TRUE(anna.WaitFor("the device process ended (exit code 137): your hand stays"));
  anna.Order("peers");
  anna.Order("quit");
  EXPECT_EQ(anna.Wait(), kExitOk);
}

TEST_F(DeviceCommand, EmergencyStopIsReportedAndHoldsUntilResumed) {
  Running anna = Start("one", Swinging("--report " + In("report")));
  ASSERT_TRUE(anna.WaitFor("anna is in session"));
  ASSERT_TRUE(WaitForForce());
  anna.Order("stop");
  EXPECT_TRUE(anna.WaitFor("device: emergency stop; type 'resume' to end it"));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  for (const double force : Forces(200)) EXPECT_EQ(force, 0);
  anna.Order("resume");
  EXPECT_TRUE(anna.WaitFor("a device's force comes back slowly"));
  anna.Order("grab right");  // a stopped hand has let go
  EXPECT_TRUE(WaitForForce());
  anna.Order("quit");
  EXPECT_EQ(anna.Wait(), kExitOk);
  EXPECT_EQ(Report().at("safety").at("stops"), 1);
}

TEST_F(DeviceCommand, KilledPeerLeavesNeitherForceNorProcess) {
  Running anna = Start("one", Swinging(""));
  ASSERT_TRUE(anna.WaitFor("anna is in session"));
  ASSERT_TRUE(WaitForForce());
  const pid_t device = DevicePid();
  ASSERT_GT(device, 0);
  anna.Kill();
  for (int i = 0; i < 200 && DevicePid() > 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_EQ(DevicePid(), -1);
  EXPECT_EQ(Forces(1).back(), 0);
}

TEST_F(DeviceCommand, ReportsAnInvalidDevice) {
  ExpectRefused(Run("one", "--name anna --hold right --device omega:7"), kExitDevice,
                "there is no driver 'omega'");
  ExpectRefused(Run("one", "--name anna --hold right --device omega"), kExitDevice,
                "there is no driver 'omega'");
  ExpectRefused(Run("one", "--name anna --hold right --device :7"), kExitUsage,
                "expected NAME[:OPTIONS]; see 'tandem devices'");
  ExpectRefused(Run("one", "--name anna --hold right --device-force 31"), kExitUsage,
                "--device-force");
}

}  // namespace
}  // namespace tandem
