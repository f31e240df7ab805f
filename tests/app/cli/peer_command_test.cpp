#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "app/process/child_processes.h"
#include "app/recording/trace_file.h"
#include "collab/dds/transport/dds_transport.h"
#include "collab/session/early_inbox.h"
#include "collab/session/viewer.h"
#include "tests/app/cli/peer_program.h"

// Tests `tandem peer` as a person uses it: who takes part, and in which scene.

namespace tandem {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using testing::ExpectRefused;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::PeerCommand;
using testing::ProgramOutput;
using testing::Running;
using testing::RunTandem;

TEST_F(PeerCommand, ReportsItsBodyAtTheEnd) {
  const ProgramOutput output = Run("one", "--name anna --hold right --hand " + In("shift.json") +
                                              " --seconds 2 --report " + In("report"));
  ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  EXPECT_THAT(output.err, HasSubstr("tandem: right stands 30"));
  EXPECT_THAT(
      output.err,
      HasSubstr(" mm from its first place; the scene has no fixed body that it could come out of"));
  std::ifstream stream(In("report"));
  const json report = json::parse(stream, nullptr, false);
  ASSERT_EQ(report.at("verdicts").size(), 1U);
  EXPECT_NEAR(report.at("verdicts")[0].at("moved_mm").get<double>(), 30, 1);
  EXPECT_TRUE(report.at("verdicts")[0].at("out").is_null());
  EXPECT_TRUE(report.at("start_gaps").empty());
}

TEST_F(PeerCommand, ReportsStartGapsAndObeysQuit) {
  // the right box stands 0.03 mm beside the left one, by voxels of 1 mm
  WriteScene("near", 0.001, "right.obj", -0.00997);
  Running anna = Start("near", "--name anna --hold right --report " + In("report"));
  ASSERT_TRUE(anna.WaitFor("anna is in session"));
  EXPECT_THAT(anna.output(), HasSubstr("left-right: 0.03 mm apart, contact needs a gap of 0.05 mm: "
                                       "a voxel_m of 0.0006 or less fits"));
  anna.Order("help");
  EXPECT_TRUE(anna.WaitFor("give BODY PEER  hand your body"));
  anna.Order("quit");
  EXPECT_EQ(anna.Wait(), kExitOk);
  std::ifstream stream(In("report"));
  EXPECT_EQ(json::parse(stream, nullptr, false).at("start_gaps").size(), 1U);
}

TEST_F(PeerCommand, HolderLearnsWhoAsksAndHowToAnswer) {
  Running anna = Start("one", "--name anna --hold left");
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  Running ben = Start("one", "--name ben");
  ASSERT_TRUE(ben.WaitFor("ben is in session"));
  ASSERT_TRUE(anna.WaitFor("ben joined"));
  ASSERT_TRUE(ben.WaitFor("anna joined"));
  ben.Order("grab left");
  EXPECT_TRUE(anna.WaitFor("ben asks for left, which you hold: 'give left ben' hands it over"));
  anna.Order("give left ben");
  EXPECT_TRUE(ben.WaitFor("you hold left"));
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_EQ(ben.End(), kExitOk);
}

TEST_F(PeerCommand, ReportsInOneLineWhyItCannotJoin) {
  ExpectRefused(RunTandem("peer --interface nosuch0 --session s --scene " + In("one.json")),
                kExitNetwork, "nosuch0");
  ExpectRefused(Run("nowhere", ""), kExitFile, "nowhere.json: there is no such file");
  WriteScene("torn", 0.001, "gone.obj");
  ExpectRefused(Run("torn", ""), kExitFile, "bodies[1].mesh: no such file");
  ExpectRefused(Run("one", "--hold nothing"), kExitUsage,
                "no moving body of that name; its moving bodies: left, right");
  ExpectRefused(Run("one", "--role viewer --hold left"), kExitUsage, "neither holds nor records");
  ExpectRefused(Run("one", "--hand " + In("nowhere.json")), kExitFile,
                "nowhere.json: there is no such file");
  ExpectRefused(Run("one", "--hold left --hand " + In("one.json")), kExitFile,
                "this is a scene, not a hand's script");
  ExpectRefused(Run("shift", ""), kExitFile, "this is a hand's script, not a scene");
}

// The newcomer, which has the lowest id, offers its own parameters before it has heard of anybody.
TEST_F(PeerCommand, WaitingPeerKeepsItsParametersBesideAnOffer) {
  EarlyInbox active_peers;
  DdsOptions options;
  options.session = session_;
  options.peer = 1;
  options.interface = "lo";
  const auto joined = JoinOverDds(options, active_peers);
  ASSERT_TRUE(joined);
  const Result<Scene> scene = LoadScene(In("two.json"));
  ASSERT_TRUE(scene);
  const Result<SceneHash> hash = HashScene(*scene);
  ASSERT_TRUE(hash);
  Running anna = Start("one", "--name anna --wait-for 1");
  const auto under_way = [&active_peers] {
    const auto offer = active_peers.SessionScene();
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
  ASSERT_TRUE(anna.WaitFor("newcomer is not accepted"));
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_THAT(anna.output(), Not(HasSubstr("this peer joins again")));
  (*joined)->Leave();
}

// The layer is offered as an earlier version of the program would.
TEST_F(PeerCommand, JoinerRefusesALayerThatMissesContacts) {
  EarlyInbox active_peers;
  DdsOptions options;
  options.session = session_;
  options.peer = 1;
  options.interface = "lo";
  const auto joined = JoinOverDds(options, active_peers);
  ASSERT_TRUE(joined);
  const Result<Scene> scene = LoadScene(In("one.json"));
  ASSERT_TRUE(scene);
  const Result<SceneHash> hash = HashScene(*scene);
  ASSERT_TRUE(hash);
  SceneManifest offer = ManifestOf(*scene, *hash, 1);
  offer.force_layer = 0;
  offer.revision = SceneManifest::kUnderWay;
  (*joined)->Publish(offer);
  ExpectRefused(Run("one", "--seconds 1"), kExitIncompatiblePeer,
                "refined contact misses contacts at force layer 0: layer 1 finds them all");
  (*joined)->Leave();
}

TEST_F(PeerCommand, JoinerWithOtherContentLearnsWhichBodyAndFile) {
  Running anna = Start("one", "--name anna");
  ASSERT_TRUE(anna.WaitFor("is in session"));
  const ProgramOutput output = Run("other", "--seconds 1");
  ExpectRefused(output, kExitIncompatiblePeer, "other.json: body \"right\": its file ");
  EXPECT_THAT(output.err, HasSubstr("wrong.obj is not the one of the session's scene \"boxes\""));
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_THAT(anna.output(), Not(HasSubstr("joined")));
}

TEST_F(PeerCommand, JoinerAdoptsTheSessionsVoxelsBeyondTheirAuthor) {
  Running anna = Start("one", "--name anna");
  ASSERT_TRUE(anna.WaitFor("is in session"));
  Running ben = Start("two", "--name ben --hold right");
  ASSERT_TRUE(ben.WaitFor("you hold right"));
  EXPECT_THAT(ben.output(),
              HasSubstr("the session uses voxels of 1 mm, refined contact, force layer "
                        "1, friction 0; this peer adopts them"));
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_THAT(anna.output(), AllOf(HasSubstr("ben joined"), Not(HasSubstr("other force"))));

  Running carl = Start("two", "--name carl --hold left");
  ASSERT_TRUE(carl.WaitFor("you hold left"));
  EXPECT_THAT(carl.output(), HasSubstr("voxels of 1 mm"));
  EXPECT_EQ(carl.End(), kExitOk);
  EXPECT_EQ(ben.End(), kExitOk);
}

TEST_F(PeerCommand, InsistingPeerIsWarnedAndGetsNoSharedBody) {
  Running anna = Start("one", "--name anna");
  ASSERT_TRUE(anna.WaitFor("is in session"));
  ExpectRefused(Run("two", "--insist --hold right"), kExitIncompatiblePeer,
                "--insist: right is shared");
  Running ben = Start("two", "--name ben --insist --hold left");
  ASSERT_TRUE(ben.WaitFor("you hold left"));
  ben.Order("grab right");
  // 0.45 of a voxel; 10 N as of ForceParameters.SmallerVoxelsPushHarder
  EXPECT_THAT(ben.output(), HasSubstr("the session pushes harder; where parts press one another, "
                                      "yours is pushed back from a gap of 0.90 mm on, theirs from "
                                      "0.45 mm, and up to 10 N a point of contact you feel all"));
  EXPECT_TRUE(anna.WaitFor("ben uses other force parameters (voxels of 2 mm"));
  EXPECT_THAT(anna.output(), HasSubstr("you push harder"));
  EXPECT_TRUE(ben.WaitFor(
      "'right' is shared: a peer with other force parameters (--insist) cannot hold it"));
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_EQ(ben.End(), kExitOk);
}

TEST_F(PeerCommand, SimultaneousStartWithOtherVoxelsConverges) {
  Running anna = Start("one", "--name anna --wait-for 1");
  Running ben = Start("two", "--name ben --wait-for 1");
  const auto adopted = [](const Running& peer) {
    return peer.output().find("this peer adopts them") != std::string::npos;
  };
  for (int i = 0; i < 500 && !adopted(anna) && !adopted(ben); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_TRUE(anna.WaitFor("ben joined"));
  EXPECT_TRUE(ben.WaitFor("anna joined"));
  EXPECT_NE(adopted(anna), adopted(ben)) << anna.output() << ben.output();
  EXPECT_EQ(anna.End(), kExitOk);
  EXPECT_EQ(ben.End(), kExitOk);
}

TEST_F(PeerCommand, LateJoinerFindsParkedBodiesInPlace) {
  Viewer active_peers;
  DdsOptions options;
  options.session = session_;
  options.peer = 1;
  options.role = Role::kViewer;
  options.interface = "lo";
  const auto joined = JoinOverDds(options, active_peers);
  ASSERT_TRUE(joined);
  Running anna = Start("one", "--name anna --hold left --hand " + In("shift.json"));
  const auto seen = [&active_peers]() -> std::optional<ViewBody> {
    const ViewerPicture picture = active_peers.Picture();
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
  })) << anna.output();
  anna.Order("release");
  ASSERT_TRUE(wait_for([&] {
    return (seen()->flags & ViewBody::kHeld) == 0;
  })) << anna.output();
  const double parked_z = seen()->X_W.p.z();
  (*joined)->Leave();
  // his file has other voxels, so he adopts those of the session
  const ProgramOutput ben = Run("two", "--name ben --hold left --seconds 1 --report " + In("ben"));
  ASSERT_EQ(ben.exit_code, kExitOk) << ben.err;
  EXPECT_THAT(ben.err, AllOf(HasSubstr("this peer adopts them"), HasSubstr("you hold left")));
  const auto trace = ReadTrace(In("ben.trace"));
  ASSERT_TRUE(trace && !trace->empty());
  EXPECT_NEAR(trace->front().X_WB.p.x(), -0.05, 2e-3);
  EXPECT_NEAR(trace->front().X_WB.p.z(), parked_z, 1e-4);
  EXPECT_EQ(anna.End(), kExitOk);
}

TEST_F(PeerCommand, OtherProtocolGivesOneLineAndAnExitCode) {
  Viewer active_peers;
  DdsOptions options;
  options.session = session_;
  options.peer = 77;
  options.interface = "lo";
  const auto joined = JoinOverDds(options, active_peers);
  ASSERT_TRUE(joined);
  PeerInfo info;
  info.peer = 77;
  info.protocol = kProtocol + 1;
  info.name = "newer";
  (*joined)->Publish(info);
  const ProgramOutput output = Run("one", "--wait-for 1 --wait-seconds 3");
  EXPECT_EQ(output.exit_code, kExitIncompatiblePeer);
  EXPECT_THAT(output.err,
              HasSubstr("newer is not accepted: it uses protocol " + std::to_string(kProtocol + 1) +
                        " and this program " + std::to_string(kProtocol)));
  EXPECT_THAT(output.err, HasSubstr("your hand waits until others hold a body"));
  (*joined)->Leave();
}

TEST_F(PeerCommand, PeersOfEqualNamesAreDistinguished) {
  Running first = Start("one", "--name anna");
  ASSERT_TRUE(first.WaitFor("is in session"));
  Running second = Start("one", "--name anna");
  EXPECT_TRUE(first.WaitFor("another anna joined, shown as anna (2)"));
  EXPECT_TRUE(second.WaitFor("another anna joined, shown as anna (2)"));
  EXPECT_EQ(first.End(), kExitOk);
  EXPECT_EQ(second.End(), kExitOk);
}

TEST_F(PeerCommand, ClearanceCanBeSetAtRunTime) {
  Running anna = Start("one", "--name anna --hold left");
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  anna.Order("displace -0.1");
  EXPECT_TRUE(anna.WaitFor("0.1 mm outwards, at this peer alone; others keep theirs in place"));
  anna.Order("layer 2");
  EXPECT_TRUE(anna.WaitFor("force layer 2 for the body you hold, at this peer alone"));
  anna.Order("layer 99");
  EXPECT_TRUE(anna.WaitFor("layer: expected a whole number from"));
  EXPECT_EQ(anna.End(), kExitOk);
}

TEST_F(PeerCommand, ViewerOnlyWatchesAndForcelessUserIsAFullPeer) {
  Running anna = Start("one", "--name anna --device none --hold left --seconds 4 --hand " +
                                  In("shift.json") + " --report " + In("anna"));
  ASSERT_TRUE(anna.WaitFor("you hold left"));
  const ProgramOutput vera =
      Run("one", "--role viewer --name vera --seconds 2 --report " + In("vera"));
  EXPECT_EQ(vera.exit_code, kExitOk);
  EXPECT_THAT(vera.err, AllOf(HasSubstr("anna joined"), HasSubstr("it is the scene given")));
  EXPECT_EQ(anna.Wait(), kExitOk);
  EXPECT_THAT(anna.output(), HasSubstr("vera (viewer) joined"));
  const json report = json::parse(std::ifstream(In("vera")), nullptr, false);
  EXPECT_GT(report.at("samples").get<int>(), 60);
  // her handle is exactly where she means it to be, and nothing is in the way of the body
  const auto trace = ReadTrace(In("anna.trace"));
  ASSERT_TRUE(trace && !trace->empty());
  EXPECT_NEAR(trace->back().X_WB.p.z(), 0.03, 1e-6);
}

TEST_F(PeerCommand, UnwritableReportIsReportedBeforeTheSession) {
  const std::string nowhere = In("nowhere/report");
  ExpectRefused(Run("one", "--report " + nowhere), kExitFile, nowhere + ": cannot be written");
  ExpectRefused(Run("one", "--report " + In("")), kExitFile, ": cannot be written");
  ExpectRefused(RunTandem("watch --interface lo --session s --report " + nowhere), kExitFile,
                nowhere + ": cannot be written");
}

TEST_F(PeerCommand, BuiltInSceneIsGivenByName) {
  const ProgramOutput output =
      RunTandem("peer --interface lo --capacity 20000 --session " + session_ +
                " --scene peg_in_slot --hold peg --seconds 0.1");
  EXPECT_EQ(output.exit_code, kExitOk) << output.err;
  for (const char* words :
       {"peer --session s --scene nosuch", "watch --session s --scene nosuch", "proximity nosuch",
        "demo --scene nosuch", "bench points --scene nosuch", "simulate --scene nosuch"}) {
    ExpectRefused(RunTandem(words), kExitFile,
                  "there is no scene 'nosuch': name a file, or one of ball_and_socket, "
                  "bracket_actuator, ");
  }
}

TEST_F(PeerCommand, EmptyHandIsToldTheBodies) {
  Running anna = Start("one", "--name anna");
  EXPECT_TRUE(anna.WaitFor(
      "your hand is empty: start with --hold BODY, or type 'grab BODY'; bodies: left, right"));
  EXPECT_EQ(anna.End(), kExitOk);
}

}  // namespace
}  // namespace tandem
