// Tests the limits of `tandem peer`: orders, time, memory, bodies, contacts.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "collab/ownership/ownership.h"
#include "tests/app/cli/peer_program.h"

namespace tandem {
namespace {

using nlohmann::json;
using testing::ExpectRefused;
using ::testing::HasSubstr;
using testing::PeerCommand;
using testing::ProgramOutput;
using testing::Running;
using testing::RunTandem;

// The peer goes on with its heartbeat, so that others do not see a ghost. It keeps to its time and
// ends when it is told to.
TEST_F(PeerCommand, EndlessOrdersDoNotBlockIt) {
  Running anna = Start("one", "--name anna");
  ASSERT_TRUE(anna.WaitFor("is in session"));
  const std::string command = std::string("yes | timeout -s KILL 40 ") + TANDEM_PROGRAM + " peer " +
                              By("one", "--name ben --seconds 1") + " >" + In("ben") + " 2>&1";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), kExitOk);
  EXPECT_TRUE(anna.WaitFor("ben left"));
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_LT(std::filesystem::file_size(In("ben")), 1U << 20U);
}

// The peer keeps its motion in locked memory, for the first ten minutes and with a report only. A
// day of it would be 12 GB.
TEST_F(PeerCommand, MemoryDoesNotGrowOverADay) {
  const auto megabytes = [this](const std::string& more, const std::string& report) {
    Running peer = Start("one", "--name anna --hold left " + more);
    EXPECT_TRUE(peer.WaitFor("you hold left")) << peer.output();
    const double kB = std::atof(peer.Memory("VmData").c_str());
    EXPECT_EQ(peer.End(), kExitOk);
    if (!report.empty()) {
      const json written = json::parse(std::ifstream(In(report)), nullptr, false);
      EXPECT_GT(written.at("traced_frames").get<int>(), 0);
    }
    return kB / 1000;
  };
  const double least = megabytes("--seconds 1000", "");
  EXPECT_NEAR(megabytes("--seconds 86400", ""), least, 20.0);
  EXPECT_NEAR(megabytes("--seconds 86400 --report " + In("day"), "day"), least + 86.4, 20.0);
  EXPECT_NEAR(megabytes("--report " + In("endless"), "endless"), least + 86.4, 20.0);
}

TEST_F(PeerCommand, TooManyBodiesAreRefusedAtOnce) {
  json scene{{"name", "many"}, {"voxel_m", 0.002}, {"bodies", json::array()}};
  for (std::size_t i = 0; i <= kMaxClaims; ++i) {
    scene["bodies"].push_back({{"name", std::string("b") + std::to_string(i)},
                               {"mesh", "left.obj"},
                               {"mass_kg", 0.1},
                               {"pose", {{"p_W", {0.1 * static_cast<double>(i), 0, 0}}}}});
  }
  folder_.Write("many.json", scene.dump());
  ExpectRefused(Run("many", ""), kExitFile,
                "many.json: 65 bodies move by themselves, in a session at most 64");
}

// The session brings everything that may come after the first second: a late joiner, bodies taken,
// shared, let go and given away, and all of it recorded.
TEST_F(PeerCommand, ItsHapticThreadHasNoPageFaults) {
  Running anna = Start("one", "--name anna --record " + In("anna.rec"));
  ASSERT_TRUE(anna.WaitFor("is in session"));
  if (anna.Memory("VmLck").find(" 0 kB") != std::string::npos) {
    EXPECT_EQ(anna.End(), kExitOk);
    GTEST_SKIP() << "memory may not be locked here";
  }
  std::this_thread::sleep_for(std::chrono::seconds(1));
  const std::optional<long> before = anna.PageFaults("haptic");
  ASSERT_TRUE(before);
  EXPECT_GT(*before, 0);  // page faults of its beginning: they are counted
  anna.Order("grab left");
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  Running ben = Start("one", "--name ben --hold right --hand " + In("shift.json"));
  ASSERT_TRUE(ben.WaitFor("you hold right"));
  ASSERT_TRUE(anna.WaitFor("ben joined"));
  anna.Order("give left ben");
  ASSERT_TRUE(anna.WaitFor("you gave left to ben")) << anna.output();
  anna.Order("grab right");
  ASSERT_TRUE(anna.WaitFor("you hold right")) << anna.output();
  anna.Order("release");
  ASSERT_TRUE(anna.WaitFor("you let go of right")) << anna.output();
  EXPECT_EQ(ben.End(), kExitOk);
  ASSERT_TRUE(anna.WaitFor("ben left")) << anna.output();
  EXPECT_EQ(anna.PageFaults("haptic"), before);
  EXPECT_EQ(anna.End(), kExitOk);
}

// No point test of a ball in its socket fits into a frame, so the ball goes at the travel floor.
TEST_F(PeerCommand, ShowsFrameLimitsToUserAndViewers) {
  Running anna("--interface lo --capacity 1 --session " + session_ +
                   " --scene " TANDEM_SCENES "/ball_and_socket.json --hold ball --name anna",
               In("anna"));
  ASSERT_TRUE(anna.WaitFor("you hold ball"));
  const ProgramOutput watched = RunTandem("watch --interface lo --seconds 5 --session " + session_);
  EXPECT_EQ(watched.exit_code, kExitOk);
  EXPECT_THAT(watched.err, HasSubstr("over capacity 100 % of its frames"));
  anna.Order("peers");
  EXPECT_TRUE(
      anna.WaitFor("in the last second, in 100 % of the frames point tests took so much time"))
      << anna.output();
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_THAT(anna.output(),
              HasSubstr("tandem: in 100 % of the frames point tests took so much time"));
}

// Ball and socket have such fine voxels and such a thick force layer that a pair cannot hold all
// its contacts.
TEST_F(PeerCommand, ReportsContactOverflowOnce) {
  const std::filesystem::path scenes = TANDEM_SCENES;
  json dense = json::parse(std::ifstream(scenes / "ball_and_socket.json"));
  dense["voxel_m"] = 0.00015;
  dense["force_layer"] = 4;
  dense["contact"] = "plain";
  for (json& body : dense["bodies"]) {
    body["mesh"] = (scenes / body["mesh"].get<std::string>()).string();
  }
  dense.erase("hands");
  folder_.Write("dense.json", dense.dump());
  const ProgramOutput output =
      Run("dense", "--hold ball --seconds 1 --report " + In("report.json") + " --hand " +
                       (scenes / "ball_and_socket_ball.json").string());
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  const std::string words = "a pair of bodies has more contacts";
  const std::size_t first = output.err.find(words);
  ASSERT_NE(first, std::string::npos) << output.err;
  EXPECT_EQ(output.err.find(words, first + 1), std::string::npos) << output.err;
  const json report = json::parse(std::ifstream(In("report.json")));
  EXPECT_GT(report.at("crowded_frames").get<int>(), 0);
  EXPECT_GT(report.at("limits").at("contacts_full_share").get<double>(), 0);
  EXPECT_LE(report.at("limits").at("contacts_full_share").get<double>(), 1);
  EXPECT_THAT(output.err,
              HasSubstr("of the frames a pair of bodies had more contacts than there is room for"));
  EXPECT_GT(report.at("contact_points").at("max").get<int>(), 1 << 14);
}

}  // namespace
}  // namespace tandem
