#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "collab/dds/security/keys.h"
#include "tests/network/control_fixture.h"

// Tests who can use a controller and what hosts can make it write, and two controllers' resets.

namespace tandem {
namespace {

using std::chrono::milliseconds;
using ControlUsersTest = testing::ControlTest;

// In a secured session, too: keys are the session's.
TEST_F(ControlUsersTest, ControllerOfASecuredSessionIsAttachedToAsAnyOther) {
  const std::filesystem::path session = folder_.path() / "session";
  const std::filesystem::path anna = folder_.path() / "anna";
  ASSERT_TRUE(MakeSessionKeys(session));
  ASSERT_TRUE(MakeMemberKeys(session, "anna", Role::kActive, anna));
  Start({"--secure", anna.string()});
  Controller host = Attach();
  EXPECT_TRUE(host.Ask(GrabRequest{.body = "peg"}).ok);
}

// Returns the UDP ports of this machine that are bound to any address.
std::set<int> UdpPorts() {
  std::set<int> ports;
  for (const char* table : {"/proc/net/udp", "/proc/net/udp6"}) {
    std::ifstream file(table);
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
      std::istringstream words(line);
      std::string number;
      std::string local;
      words >> number >> local;
      ports.insert(std::stoi(local.substr(local.find(':') + 1), nullptr, 16));
    }
  }
  return ports;
}

// DDS has 250 ports from 7400 + 250 * domain on; 43 was the domain of controllers.
TEST_F(ControlUsersTest, ControllerOpensNoPortButTheSessions) {
  Start();
  Controller host = Attach();
  const std::set<int> ports = UdpPorts();
  EXPECT_TRUE(std::ranges::any_of(ports, [](int port) {
    return port >= 7400 + 250 * 42 && port < 7400 + 250 * 43;
  })) << "the session's";
  EXPECT_FALSE(std::ranges::any_of(ports, [](int port) {
    return port >= 7400 + 250 * 43 && port < 7400 + 250 * 44;
  }));
  EXPECT_TRUE(host.Ask(QuitRequest{}).ok);
}

TEST_F(ControlUsersTest, AnotherUserNeitherAttachesNorFindsTheSocket) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can become another user";
  Start();
  Controller host = Attach();
  const std::filesystem::path socket = folder_.path() / "tandem" / (name_ + ".sock");
  ASSERT_TRUE(std::filesystem::exists(socket));
  Result<ChildProcess> listing = ChildProcess::Start(
      {"/usr/bin/setpriv", "--reuid", "65534", "--clear-groups", "/bin/ls", socket.string()});
  ASSERT_TRUE(listing);
  EXPECT_NE(listing->Wait(std::chrono::seconds(10)), 0);
}

TEST_F(ControlUsersTest, SavesNoFileThatAShellReads) {
  Start();
  Controller host = Attach();
  for (const char* name : {".bash_profile", "x.sh", ".profile.json"}) {
    const std::filesystem::path file = folder_.path() / name;
    const Answer answer = host.Ask(SaveRequest{file.string()});
    EXPECT_FALSE(answer.ok) << name;
    EXPECT_NE(answer.reason.find("choose another name"), std::string::npos) << answer.reason;
    EXPECT_FALSE(std::filesystem::exists(file));
  }
}

TEST_F(ControlUsersTest, HostHearsNothingOfAFileThatIsNoScene) {
  Start();
  Controller host = Attach();
  const std::filesystem::path file = folder_.path() / "shadow";
  std::ofstream(file) << "root:verysecret:1:0:99999";
  for (const ControlRequest& request : std::vector<ControlRequest>{
           LoadSceneRequest{file.string()}, LoadMeshRequest{.file = file.string(), .body = {}},
           VoxelizeRequest{file.string()}}) {
    const Answer answer = host.Ask(request, 20);
    EXPECT_FALSE(answer.ok);
    EXPECT_EQ(answer.reason.find("root"), std::string::npos) << answer.reason;
    EXPECT_EQ(answer.reason.find("secret"), std::string::npos) << answer.reason;
  }
}

// Two users in one session: anna moves the peg and hands it over, ben moves it on.
TEST_F(ControlUsersTest, ResetPutsBackWhatAnotherUserMovedLast) {
  Start();
  Controller anna = Attach();
  ChildProcess annas = *std::move(controller_);
  const std::string session = name_;
  Result<ChildProcess> started = ChildProcess::Start(
      {TANDEM_PROGRAM, "peer", "--session", session, "--scene",
       std::string(TANDEM_SCENES) + "/peg_in_slot.json", "--interface", "lo", "--name", "ben",
       "--control", name_ + "-ben", "--capacity", "20000", "--brief"});
  ASSERT_TRUE(started);
  controller_.emplace(*std::move(started));
  name_ += "-ben";
  Controller ben = Attach();
  const auto slides = [](Controller& host, double way) {
    while (host.snapshot().hand.body < 0) host.Wait(milliseconds(50));
    PlainPose goal = host.snapshot().hand.X_WG;
    goal.p_W[0] += way;
    host.SetGoal(goal);
    const auto body = static_cast<std::size_t>(host.snapshot().hand.body);
    const double from = host.snapshot().bodies[body].X_W.p_W[0];
    for (int i = 0; i < 300; ++i) {
      host.Wait(milliseconds(20));
      if (host.snapshot().bodies[body].X_W.p_W[0] - from > 0.9 * way) return body;
    }
    return std::size_t{99};
  };
  ASSERT_TRUE(anna.Ask(GrabRequest{.body = "peg"}).ok);
  const std::size_t peg = slides(anna, 0.02);
  ASSERT_LT(peg, 2U);
  Answer given;
  for (int i = 0; i < 100 && !given.ok; ++i) {
    given = anna.Ask(GiveRequest{"ben"});  // until anna has met ben
    anna.Wait(milliseconds(50));
  }
  ASSERT_TRUE(given.ok) << given.reason;
  ASSERT_EQ(slides(ben, 0.02), peg);
  Answer back = anna.Ask(RetraceRequest{RetraceRequest::To::kReset});
  EXPECT_FALSE(back.ok);
  EXPECT_EQ(back.reason, "0 bodies went back; peg did not: ben holds it");
  ASSERT_TRUE(ben.Ask(ReleaseRequest{}).ok);
  for (int i = 0; i < 100 && !anna.snapshot().bodies[peg].holders.empty(); ++i) {
    anna.Wait(milliseconds(50));  // until anna's program has heard of it
  }
  // ben has not held it where it began, and anna has not moved it last
  back = anna.Ask(RetraceRequest{RetraceRequest::To::kReset});
  EXPECT_TRUE(back.ok) << back.reason;
  EXPECT_EQ(back.reason, "1 body went back");
  anna.Wait(milliseconds(200));
  for (const double p : anna.snapshot().bodies[peg].X_W.p_W) EXPECT_NEAR(p, 0, 2.5e-3);
  anna.Send(QuitRequest{});
  ben.Send(QuitRequest{});
  EXPECT_EQ(annas.Wait(std::chrono::seconds(20)), 0);
  EXPECT_EQ(controller_->Wait(std::chrono::seconds(20)), 0);
}

}  // namespace
}  // namespace tandem
