#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "app/cli/child_processes.h"
#include "app/cli/peer_report.h"
#include "app/exit_codes.h"
#include "collab/dds/dds_transport.h"
#include "collab/early_inbox.h"
#include "collab/viewer.h"
#include "tests/app/cli/program_run.h"

// `tandem peer` as a person uses it: who takes part, and in which scene.

namespace tandem {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::RunTandem;
using testing::Said;

/// A box of these half sides in Wavefront's format, and a remark.
std::string BoxFile(double x, double y, double z, const std::string& remark = "") {
  std::ostringstream text;
  for (unsigned corner = 0; corner < 8; ++corner) {
    text << "v " << ((corner & 1U) != 0 ? x : -x) << " " << ((corner & 2U) != 0 ? y : -y) << " "
         << ((corner & 4U) != 0 ? z : -z) << "\n";
  }
  text << "f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\n"
          "f 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n#"
       << remark << "\n";
  return text.str();
}

/// A peer that runs beside the test, and takes orders from it.
class Running {
 public:
  Running(const std::string& arguments, const std::filesystem::path& said) : said_(said) {
    // a pipe with a name, for what is started is the peer itself and ends when it is told to
    const std::string orders = said.string() + ".orders";
    EXPECT_EQ(mkfifo(orders.c_str(), 0600), 0);
    orders_ = open(orders.c_str(), O_RDWR | O_CLOEXEC);
    EXPECT_GE(orders_, 0);
    Result<ChildProcess> started =
        ChildProcess::Start({"/bin/sh", "-c",
                             std::string("exec ") + TANDEM_PROGRAM + " peer " + arguments + " <" +
                                 orders + " >" + said.string() + " 2>&1"});
    EXPECT_TRUE(started);
    process_.emplace(*std::move(started));
  }
  Running(Running&& other) noexcept
      : said_(std::move(other.said_)),
        orders_(std::exchange(other.orders_, -1)),
        process_(std::move(other.process_)) {}
  Running& operator=(Running&&) = delete;
  ~Running() {
    if (orders_ >= 0) close(orders_);
  }

  /// Says a line to it.
  void Order(const std::string& line) const {
    EXPECT_EQ(write(orders_, (line + "\n").data(), line.size() + 1),
              static_cast<ssize_t>(line.size() + 1));
  }
  std::string said() const {
    std::ostringstream text;
    text << std::ifstream(said_).rdbuf();
    return text.str();
  }
  /// Whether it has said this within some seconds.
  bool WaitFor(const std::string& words, double seconds = 15) const {
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < until) {
      if (said().find(words) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }
  /// Of /proc's words on its memory, what follows `of`.
  std::string Memory(const std::string& of) const {
    std::ifstream status("/proc/" + std::to_string(process_->pid()) + "/status");
    for (std::string line; std::getline(status, line);) {
      if (line.rfind(of + ":", 0) == 0) return line.substr(of.size() + 1);
    }
    return {};
  }
  /// Page faults so far of its thread of that name, of either kind; nothing if there is none.
  std::optional<long> PageFaults(const std::string& thread) const {
    const std::string tasks = "/proc/" + std::to_string(process_->pid()) + "/task";
    std::error_code gone;
    for (const auto& task : std::filesystem::directory_iterator(tasks, gone)) {
      std::ifstream stat(task.path() / "stat");
      std::string line;
      std::getline(stat, line);
      const std::size_t end = line.rfind(") ");
      if (end == std::string::npos || line.find(thread + ")") == std::string::npos) continue;
      // state, ppid, pgrp, session, tty, tpgid, flags, minflt, cminflt, majflt
      std::istringstream words(line.substr(end + 2));
      std::vector<std::string> field(10);
      for (std::string& word : field) words >> word;
      return std::stol(field[7]) + std::stol(field[9]);
    }
    return std::nullopt;
  }
  int Wait() { return process_->Wait(std::chrono::seconds(30)).value_or(-1); }
  int End() {
    process_->Signal(SIGTERM);
    return Wait();
  }

 private:
  std::filesystem::path said_;
  int orders_ = -1;
  std::optional<ChildProcess> process_;
};

/// Two boxes, the right one shared, by voxels of 1 mm (`one`) and 2 mm (`two`); `other` has another
/// mesh for the right one.
class PeerCommand : public ::testing::Test {
 protected:
  PeerCommand() : session_("peers-" + std::to_string(std::random_device{}())) {
    folder_.Write("left.obj", BoxFile(0.02, 0.02, 0.02));
    folder_.Write("right.obj", BoxFile(0.02, 0.02, 0.02));
    folder_.Write("wrong.obj", BoxFile(0.02, 0.02, 0.02, "another"));
    folder_.Write("shift.json", R"({"waypoints": [
        {"t_s": 0, "p_W": [0, 0, 0], "q_xyzw": [0, 0, 0, 1]},
        {"t_s": 0.5, "p_W": [0, 0, 0.03], "q_xyzw": [0, 0, 0, 1]}]})");
    WriteScene("one", 0.001, "right.obj");
    WriteScene("two", 0.002, "right.obj");
    WriteScene("other", 0.001, "wrong.obj");
  }
  void WriteScene(const std::string& name, double voxel_m, const std::string& mesh) {
    json scene{{"name", "boxes"}, {"voxel_m", voxel_m}};
    scene["bodies"] = {{{"name", "left"},
                        {"mesh", "left.obj"},
                        {"mass_kg", 0.1},
                        {"pose", {{"p_W", {-0.05, 0, 0}}}}},
                       {{"name", "right"},
                        {"mesh", mesh},
                        {"mass_kg", 0.1},
                        {"sharing", "shared"},
                        {"pose", {{"p_W", {0.05, 0, 0}}}}}};
    folder_.Write(name + ".json", scene.dump());
  }
  std::string In(const std::string& file) const { return (folder_.path() / file).string(); }
  /// The words of a peer by one of the scenes.
  std::string By(const std::string& scene, const std::string& more) const {
    return "--interface lo --capacity 20000 --session " + session_ + " --scene " +
           In(scene + ".json") + " " + more;
  }
  Running Start(const std::string& scene, const std::string& more) {
    return {By(scene, more), In("said" + std::to_string(started_++))};
  }
  Said Run(const std::string& scene, const std::string& more) const {
    return RunTandem("peer " + By(scene, more), "timeout 40 ");
  }

  ScratchFolder folder_;
  std::string session_;
  int started_ = 0;
};

/// One line with these words, and this exit code.
void ExpectRefused(const Said& said, int exit_code, const std::string& words) {
  EXPECT_EQ(said.exit_code, exit_code) << said.err;
  EXPECT_THAT(said.err, HasSubstr(words));
  EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
}

TEST_F(PeerCommand, SaysInALineWhatKeepsItOut) {
  ExpectRefused(RunTandem("peer --interface nosuch0 --session s --scene " + In("one.json")),
                kExitNetwork, "nosuch0");
  ExpectRefused(Run("nowhere", ""), kExitFile, "nowhere.json: cannot be read");
  WriteScene("torn", 0.001, "gone.obj");
  ExpectRefused(Run("torn", ""), kExitFile, "bodies[1].mesh: no such file");
  ExpectRefused(Run("one", "--hold nothing"), kExitUsage, "no moving body of that name");
  ExpectRefused(Run("one", "--role viewer --hold left"), kExitUsage, "neither holds nor records");
  ExpectRefused(Run("one", "--hand " + In("nowhere.json")), kExitFile, "nowhere.json");
}

// One that comes late, and has the lowest id, offers its own before it has heard of anybody.
TEST_F(PeerCommand, WhoWaitsUnderWayKeepsToItsParametersBesideANewcomersOffer) {
  EarlyInbox ears;
  DdsOptions options;
  options.session = session_;
  options.peer = 1;
  options.interface = "lo";
  const auto joined = JoinOverDds(options, ears);
  ASSERT_TRUE(joined);
  const Result<Scene> scene = LoadScene(In("two.json"));
  ASSERT_TRUE(scene);
  const Result<SceneHash> hash = HashScene(*scene);
  ASSERT_TRUE(hash);
  Running anna = Start("one", "--name anna --wait-for 1");
  const auto under_way = [&ears] {
    const auto offer = ears.SessionScene();
    return offer && offer->revision == SceneManifest::kUnderWay;
  };
  for (int i = 0; i < 1000 && !under_way(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSERT_TRUE(under_way());
  (*joined)->Publish(ManifestOf(*scene, *hash, 1));
  PeerInfo info;
  info.peer = 1;
  info.protocol = kProtocol + 1;  // so that she goes on waiting
  info.name = "newcomer";
  (*joined)->Publish(info);
  ASSERT_TRUE(anna.WaitFor("newcomer is not taken in"));
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_THAT(anna.said(), Not(HasSubstr("joining anew")));
  (*joined)->Leave();
}

TEST_F(PeerCommand, AJoinerOfOtherContentIsToldWhichBodyAndFile) {
  Running anna = Start("one", "--name anna");
  ASSERT_TRUE(anna.WaitFor("is in session"));
  const Said said = Run("other", "--seconds 1");
  ExpectRefused(said, kExitIncompatiblePeer, "other.json: body \"right\": its file ");
  EXPECT_THAT(said.err, HasSubstr("wrong.obj is not the one of the session's scene \"boxes\""));
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_THAT(anna.said(), Not(HasSubstr("joined")));
}

TEST_F(PeerCommand, AJoinerOfOtherVoxelsAdoptsTheSessionsWhichOutliveTheirAuthor) {
  Running anna = Start("one", "--name anna");
  ASSERT_TRUE(anna.WaitFor("is in session"));
  Running ben = Start("two", "--name ben --hold right");
  ASSERT_TRUE(ben.WaitFor("you hold right"));
  EXPECT_THAT(ben.said(), HasSubstr("the session goes by voxels of 1 mm, refined contact, force "
                                    "layer 1, friction 0, which is adopted"));
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_THAT(anna.said(), AllOf(HasSubstr("ben joined"), Not(HasSubstr("other force"))));

  Running carl = Start("two", "--name carl --hold left");
  ASSERT_TRUE(carl.WaitFor("you hold left"));
  EXPECT_THAT(carl.said(), HasSubstr("voxels of 1 mm"));
  EXPECT_EQ(carl.End(), kExitOk);
  EXPECT_EQ(ben.End(), kExitOk);
}

TEST_F(PeerCommand, WhoInsistsIsToldWhoPushesHarderAndGetsNoSharedBody) {
  Running anna = Start("one", "--name anna");
  ASSERT_TRUE(anna.WaitFor("is in session"));
  ExpectRefused(Run("two", "--insist --hold right"), kExitIncompatiblePeer,
                "--insist: right is shared");
  Running ben = Start("two", "--name ben --insist --hold left");
  ASSERT_TRUE(ben.WaitFor("you hold left"));
  ben.Order("grab right");
  // 0.45 of a voxel; 12 N as of ForceParameters.WhoHasTheSmallerVoxelsPushesHarder
  EXPECT_THAT(ben.said(), HasSubstr("the session pushes harder; where parts press one another, "
                                    "yours is pushed back from a gap of 0.90 mm on, theirs from "
                                    "0.45 mm, and up to 12 N a point of contact you feel all"));
  EXPECT_TRUE(anna.WaitFor("ben goes by other force parameters (voxels of 2 mm"));
  EXPECT_THAT(anna.said(), HasSubstr("you push harder"));
  EXPECT_TRUE(ben.WaitFor("'right' is shared: it is not held by other force parameters"));
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_EQ(ben.End(), kExitOk);
}

TEST_F(PeerCommand, OfTwoWhoBeginAtOnceByOtherVoxelsOneAdoptsTheOthers) {
  Running anna = Start("one", "--name anna --wait-for 1");
  Running ben = Start("two", "--name ben --wait-for 1");
  const auto adopted = [](const Running& peer) {
    return peer.said().find("which is adopted") != std::string::npos;
  };
  for (int i = 0; i < 500 && !adopted(anna) && !adopted(ben); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_TRUE(anna.WaitFor("ben joined"));
  EXPECT_TRUE(ben.WaitFor("anna joined"));
  EXPECT_NE(adopted(anna), adopted(ben)) << anna.said() << ben.said();
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_EQ(ben.End(), kExitOk);
}

TEST_F(PeerCommand, ALateJoinerFindsAParkedBodyWhereItWasPut) {
  Viewer ears;
  DdsOptions options;
  options.session = session_;
  options.peer = 1;
  options.role = Role::kViewer;
  options.interface = "lo";
  const auto joined = JoinOverDds(options, ears);
  ASSERT_TRUE(joined);
  Running anna = Start("one", "--name anna --hold left --hand " + In("shift.json"));
  const auto seen = [&ears]() -> std::optional<ViewBody> {
    const ViewerPicture picture = ears.Picture();
    if (picture.peers.empty() || picture.peers[0].bodies.empty()) return std::nullopt;
    return picture.peers[0].bodies[0];
  };
  const auto wait_for = [](const auto& condition) {
    for (int i = 0; i < 1500 && !condition(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return condition();
  };
  ASSERT_TRUE(wait_for([&] {
    return seen() && seen()->X_W.p.z() > 0.02;
  })) << anna.said();
  anna.Order("release");
  ASSERT_TRUE(wait_for([&] {
    return (seen()->flags & ViewBody::kHeld) == 0;
  })) << anna.said();
  const double parked_z = seen()->X_W.p.z();
  (*joined)->Leave();
  // by the way of agreement: his file has other voxels
  const Said ben = Run("two", "--name ben --hold left --seconds 1 --report " + In("ben"));
  ASSERT_EQ(ben.exit_code, kExitOk) << ben.err;
  EXPECT_THAT(ben.err, AllOf(HasSubstr("which is adopted"), HasSubstr("you hold left")));
  const auto trace = ReadTrace(In("ben.trace"));
  ASSERT_TRUE(trace && !trace->empty());
  EXPECT_NEAR(trace->front().X_WB.p.x(), -0.05, 2e-3);
  EXPECT_NEAR(trace->front().X_WB.p.z(), parked_z, 1e-4);
  EXPECT_EQ(anna.End(), kExitOk);
}

TEST_F(PeerCommand, AnotherProtocolIsToldInALineAndAsAnExitCode) {
  Viewer ears;
  DdsOptions options;
  options.session = session_;
  options.peer = 77;
  options.interface = "lo";
  const auto joined = JoinOverDds(options, ears);
  ASSERT_TRUE(joined);
  PeerInfo info;
  info.peer = 77;
  info.protocol = kProtocol + 1;
  info.name = "newer";
  (*joined)->Publish(info);
  const Said said = Run("one", "--wait-for 1 --wait-seconds 3");
  EXPECT_EQ(said.exit_code, kExitIncompatiblePeer);
  EXPECT_THAT(said.err,
              HasSubstr("newer is not taken in: it speaks protocol " +
                        std::to_string(kProtocol + 1) + " and we " + std::to_string(kProtocol)));
  EXPECT_THAT(said.err, HasSubstr("your hand waits for others who hold a body"));
  (*joined)->Leave();
}

TEST_F(PeerCommand, TwoOfOneNameAreToldApart) {
  Running first = Start("one", "--name anna");
  ASSERT_TRUE(first.WaitFor("is in session"));
  Running second = Start("one", "--name anna");
  EXPECT_TRUE(first.WaitFor("another anna joined, shown as anna (2)"));
  EXPECT_TRUE(second.WaitFor("another anna joined, shown as anna (2)"));
  EXPECT_EQ(first.End(), kExitOk);
  EXPECT_EQ(second.End(), kExitOk);
}

TEST_F(PeerCommand, AClearanceIsOrderedWhileItRuns) {
  Running anna = Start("one", "--name anna --hold left");
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  anna.Order("displace -0.1");
  EXPECT_TRUE(anna.WaitFor("0.1 mm outwards, here alone: others have it undisplaced"));
  anna.Order("layer 3");
  EXPECT_TRUE(anna.WaitFor("force layer 3 of what your hand holds, here alone"));
  anna.Order("layer 99");
  EXPECT_TRUE(anna.WaitFor("layer: expected a whole number from"));
  EXPECT_EQ(anna.End(), kExitOk);
}

TEST_F(PeerCommand, AViewerLooksOnAndAUserWithoutForceFeedbackIsOtherwiseEqual) {
  Running anna = Start("one", "--name anna --device none --hold left --seconds 4 --hand " +
                                  In("shift.json") + " --report " + In("anna"));
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  const Said vera = Run("one", "--role viewer --name vera --seconds 2 --report " + In("vera"));
  EXPECT_EQ(vera.exit_code, kExitOk);
  EXPECT_THAT(vera.err, AllOf(HasSubstr("anna joined"), HasSubstr("it is the scene given")));
  EXPECT_EQ(anna.Wait(), kExitOk);
  EXPECT_THAT(anna.said(), HasSubstr("vera (viewer) joined"));
  const json report = json::parse(std::ifstream(In("vera")), nullptr, false);
  EXPECT_GT(report.at("samples").get<int>(), 60);
  // her handle is exactly where she means it to be, and nothing is in the way of the body
  const auto trace = ReadTrace(In("anna.trace"));
  ASSERT_TRUE(trace && !trace->empty());
  EXPECT_NEAR(trace->back().X_WB.p.z(), 0.03, 1e-6);
}

// It beats on, so that others do not see a ghost, keeps to its time and ends when it is told to.
TEST_F(PeerCommand, OrdersWithoutEndDoNotKeepItFromAnything) {
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

// What is kept of the motion is kept in locked memory: the first ten minutes, and with a report
// only. A day of it would be 12 GB.
TEST_F(PeerCommand, ADayTakesNoMoreMemoryThanTenMinutes) {
  const auto megabytes = [this](const std::string& more, const std::string& report) {
    Running peer = Start("one", "--name anna --hold left " + more);
    EXPECT_TRUE(peer.WaitFor("you hold left")) << peer.said();
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

TEST_F(PeerCommand, MoreBodiesThanOneMayAnswerForAreRefusedAtOnce) {
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

TEST_F(PeerCommand, AReportThatCannotBeWrittenIsToldBeforeTheSession) {
  const std::string nowhere = In("nowhere/report");
  ExpectRefused(Run("one", "--report " + nowhere), kExitFile, nowhere + ": cannot be written");
  ExpectRefused(Run("one", "--report " + In("")), kExitFile, ": cannot be written");
  ExpectRefused(RunTandem("watch --interface lo --session s --report " + nowhere), kExitFile,
                nowhere + ": cannot be written");
}

TEST_F(PeerCommand, ASceneOfOursGoesByItsName) {
  const Said said = RunTandem("peer --interface lo --capacity 20000 --session " + session_ +
                              " --scene peg_in_slot --hold peg --seconds 0.1");
  EXPECT_EQ(said.exit_code, kExitOk) << said.err;
  for (const char* words :
       {"peer --session s --scene nosuch", "watch --session s --scene nosuch", "proximity nosuch",
        "demo --scene nosuch", "bench points --scene nosuch", "simulate --scene nosuch"}) {
    ExpectRefused(RunTandem(words), kExitFile,
                  "there is no scene 'nosuch': name a file, or one of ball_and_socket, "
                  "bracket_actuator, ");
  }
}

TEST_F(PeerCommand, AnEmptyHandIsToldWhatThereIs) {
  Running anna = Start("one", "--name anna");
  EXPECT_TRUE(anna.WaitFor(
      "your hand is empty: --hold BODY, or 'grab BODY' as a line here, of: left, right"));
  EXPECT_EQ(anna.End(), kExitOk);
}

// Whatever a session brings after the first second: a late joiner, bodies taken, shared, let go and
// given away, and all of it recorded.
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
  EXPECT_GT(*before, 0);  // of its beginning: they are counted
  anna.Order("grab left");
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  Running ben = Start("one", "--name ben --hold right --hand " + In("shift.json"));
  ASSERT_TRUE(ben.WaitFor("you hold right"));
  ASSERT_TRUE(anna.WaitFor("ben joined"));
  anna.Order("give left ben");
  ASSERT_TRUE(anna.WaitFor("you gave left to ben")) << anna.said();
  anna.Order("grab right");
  ASSERT_TRUE(anna.WaitFor("you hold right")) << anna.said();
  anna.Order("release");
  ASSERT_TRUE(anna.WaitFor("you let go of right")) << anna.said();
  EXPECT_EQ(ben.End(), kExitOk);
  ASSERT_TRUE(anna.WaitFor("ben left")) << anna.said();
  EXPECT_EQ(anna.PageFaults("haptic"), before);
  EXPECT_EQ(anna.End(), kExitOk);
}

// Ball and socket by voxels so fine, and a force layer so thick, that a pair cannot hold all that
// is in contact.
TEST_F(PeerCommand, SaysOnceThatContactsAreMoreThanThereIsRoomFor) {
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
  const Said said = Run("dense", "--hold ball --seconds 1 --report " + In("report.json") +
                                     " --hand " + (scenes / "ball_and_socket_ball.json").string());
  ASSERT_EQ(said.exit_code, kExitOk) << said.err;
  const std::string words = "more contacts than there is room for";
  const std::size_t first = said.err.find(words);
  ASSERT_NE(first, std::string::npos) << said.err;
  EXPECT_EQ(said.err.find(words, first + 1), std::string::npos) << said.err;
  const json report = json::parse(std::ifstream(In("report.json")));
  EXPECT_GT(report.at("crowded_frames").get<int>(), 0);
  EXPECT_GT(report.at("contact_points").at("max").get<int>(), 1 << 14);
}

}  // namespace
}  // namespace tandem
