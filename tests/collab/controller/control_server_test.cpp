#include "collab/controller/control_server.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "tests/collab/controller/fake_peer.h"

namespace tandem {
namespace {

using testing::FakePeer;
using testing::FourBodies;

constexpr HostId kWindow = 11;
constexpr HostId kScript = 12;

/// A server with a scene, in virtual time.
class ControlServerTest : public ::testing::Test {
 protected:
  ControlServerTest() { server_.OnScene(FourBodies(), now_ns_); }

  void Send(HostId host, const ControlRequest& request) {
    server_.OnRequest(host, host == kWindow ? "window" : "script", ++number_, request, now_ns_);
  }
  /// Lets time pass, in which the given hosts live.
  void Run(std::int64_t ms, std::initializer_list<HostId> alive) {
    for (std::int64_t i = 0; i < ms; ++i) {
      now_ns_ += kMs;
      for (const HostId host : alive) server_.OnGoal(host, {}, now_ns_);
      peer_.facts.time_ns = now_ns_;
      server_.OnFacts(peer_.facts, now_ns_);
      server_.Tick(now_ns_);
      for (HostAnswer& answer : server_.TakeAnswers()) answers_.push_back(std::move(answer));
    }
  }
  /// Returns the answer to a request, which comes within so long.
  Answer Ask(HostId host, const ControlRequest& request, std::int64_t ms = 10) {
    Send(host, request);
    const std::uint64_t number = number_;
    Run(ms, {kWindow, kScript});
    for (const HostAnswer& answer : answers_) {
      if (answer.host == host && answer.number == number) return answer.answer;
    }
    return {false, "no answer"};
  }
  static HostGoal GoalAt(double x, std::uint32_t seq) {
    HostGoal goal{.kind = HostGoal::Kind::kPose, .seq = seq};
    goal.X_WG.p.x() = x;
    return goal;
  }

  std::int64_t now_ns_ = 1000 * kMs;
  std::uint64_t number_ = 0;
  FakePeer peer_;
  ControlServer server_{peer_, false};
  std::vector<HostAnswer> answers_;
};

TEST_F(ControlServerTest, AnswersAGrabWhenThePartIsInHand) {
  peer_.deaf = true;
  EXPECT_EQ(Ask(kWindow, GrabRequest{.body = "peg"}).reason, "no answer");
  peer_.facts.held = 0;
  Run(5, {kWindow});
  EXPECT_TRUE(answers_.empty()) << "held, and not yet grasped";
  peer_.facts.attached = true;
  Run(5, {kWindow});
  ASSERT_EQ(answers_.size(), 1U);
  EXPECT_TRUE(answers_[0].answer.ok);
  EXPECT_EQ(server_.Snapshot().hand.body, 1);
}

TEST_F(ControlServerTest, ReportsWhyAGrabFails) {
  EXPECT_EQ(Ask(kWindow, GrabRequest{.body = "hammer"}).reason, "the scene has no body 'hammer'");
  EXPECT_EQ(Ask(kWindow, GrabRequest{.body = "table"}).reason,
            "'table' is fixed: nobody can take it");
  peer_.deaf = true;
  Send(kWindow, GrabRequest{.body = "peg"});
  Run(10, {kWindow});
  server_.OnNews({Notification::Kind::kRefused, 1, 9}, "ben holds peg");
  Run(1, {kWindow});
  ASSERT_FALSE(answers_.empty());
  EXPECT_FALSE(answers_.back().answer.ok);
  EXPECT_EQ(answers_.back().answer.reason, "ben holds peg");
}

TEST_F(ControlServerTest, GrabbingTheHeldPartGrabsItAgain) {
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  const std::uint32_t grasp = peer_.goal.grasp_seq;
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg", .grasp_W = {{0.1, 0, 0}}}).ok);
  EXPECT_EQ(peer_.goal.grasp_seq, grasp + 1);
  EXPECT_FALSE(peer_.goal.at_centre);
  EXPECT_EQ(peer_.Count(Command::Kind::kRelease), 1U);
}

TEST_F(ControlServerTest, OnlyTheControllingHostsGoalsCount) {
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  server_.OnGoal(kScript, GoalAt(5, 1), now_ns_);
  EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.0);
  server_.OnGoal(kWindow, GoalAt(0.2, 2), now_ns_);
  EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.2);
  server_.OnGoal(kWindow, GoalAt(0.1, 1), now_ns_);
  EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.2) << "an older one came late";
  EXPECT_EQ(Ask(kScript, GrabRequest{.body = "bolt"}).reason,
            "the hand is in use by the host 'window'");
}

// `tandem peer --hold peg --control NAME` holds the part in this way, and a window is told of it.
TEST_F(ControlServerTest, FirstHostWithAGoalLeadsTheInitiallyHeldPart) {
  peer_.facts.wanted = peer_.facts.held = 0;
  Run(5, {kWindow, kScript});
  EXPECT_EQ(server_.Snapshot().hand.host, 0U) << "none leads it by being there";
  server_.OnGoal(kScript, GoalAt(0.4, 1), now_ns_);
  EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.4);
  EXPECT_EQ(server_.Snapshot().hand.host, kScript);
  server_.OnGoal(kWindow, GoalAt(5, 1), now_ns_);
  EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.4);
  server_.OnGoal(kScript, GoalAt(0.5, 2), now_ns_);
  EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.5);
}

TEST_F(ControlServerTest, SilentHostIsStoppedAndReleasesAfterHalfASecond) {
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  server_.OnGoal(kWindow, GoalAt(0.3, 1), now_ns_);
  peer_.facts.handle.p.x() = 0.1;  // on its way
  Run(140, {});
  EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.3);
  Run(20, {});
  EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.1) << "held where it is";
  Run(330, {});
  EXPECT_EQ(peer_.facts.held, 0) << "490 ms";
  Run(20, {});
  EXPECT_EQ(peer_.facts.held, -1) << "510 ms";
  EXPECT_EQ(server_.Snapshot().news, "the host 'window' is gone: the hand lets go");
  // the next one finds all, and takes the hand
  EXPECT_TRUE(Ask(kScript, GrabRequest{.body = "peg"}).ok);
}

TEST_F(ControlServerTest, ReturningHostResumes) {
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  server_.OnGoal(kWindow, GoalAt(0.3, 1), now_ns_);
  Run(300, {});
  ASSERT_EQ(peer_.goal.X_WG.p.x(), 0.0) << "held still";
  server_.OnGoal(kWindow, GoalAt(0.3, 1), now_ns_);  // the library says the newest again
  EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.3);
  Run(400, {kWindow});
  EXPECT_EQ(peer_.facts.held, 0);
}

TEST_F(ControlServerTest, GoalFromBeforeTheGrabIsIgnored) {
  server_.OnGoal(kWindow, GoalAt(5, 1), now_ns_);
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  server_.OnGoal(kWindow, GoalAt(5, 1), now_ns_);  // the library says the newest again
  EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.0);
  Run(300, {});
  server_.OnGoal(kWindow, GoalAt(5, 1), now_ns_);
  EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.0) << "nor after a silence";
}

TEST_F(ControlServerTest, NonFiniteGoalIsIgnored) {
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  std::uint32_t seq = 1;
  server_.OnGoal(kWindow, GoalAt(0.2, seq), now_ns_);
  // the last one's length is beyond the largest number: a hand that went there would stand
  for (const double x : {std::nan(""), 2e3, 1e300}) {
    server_.OnGoal(kWindow, GoalAt(x, ++seq), now_ns_);
    HostGoal rate{.kind = HostGoal::Kind::kRate, .seq = ++seq};
    rate.linear.z() = x;
    server_.OnGoal(kWindow, rate, now_ns_);
    EXPECT_EQ(peer_.goal.X_WG.p.x(), 0.2) << x;
    EXPECT_EQ(peer_.goal.input, GoalOrder::Input::kPose) << x;
  }
}

TEST_F(ControlServerTest, GoodbyeReleasesThePartAtOnce) {
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  server_.OnGoal(kWindow, {.kind = HostGoal::Kind::kGoodbye}, now_ns_);
  Run(1, {});
  EXPECT_EQ(peer_.facts.held, -1);
}

TEST_F(ControlServerTest, LostHostDoesNotAffectADevicesHand) {
  FakePeer peer;
  peer.facts.goal_device = false;
  ControlServer server(peer, true);
  server.OnScene(FourBodies(), 0);
  server.OnRequest(kWindow, "window", 1, GrabRequest{.body = "peg"}, 0);
  for (std::int64_t t = 1; t < 2000; ++t) {
    server.OnFacts(peer.facts, t * kMs);
    server.Tick(t * kMs);
  }
  EXPECT_EQ(peer.facts.held, 0);
  EXPECT_EQ(peer.Count(Command::Kind::kRelease), 0U);
  EXPECT_EQ(server.rate_hz(), 0.0) << "the host is gone all the same";
}

TEST_F(ControlServerTest, EmergencyStopReleasesUntilResumed) {
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  EXPECT_TRUE(Ask(kScript, EmergencyStopRequest{}).ok) << "anybody may";
  EXPECT_TRUE(peer_.stopped);
  EXPECT_EQ(peer_.facts.held, -1);
  EXPECT_EQ(server_.Snapshot().hand.state, SnapshotHand::State::kStopped);
  EXPECT_EQ(server_.Snapshot().safety.state, SnapshotSafety::State::kStopped);
  EXPECT_EQ(Ask(kWindow, GrabRequest{.body = "peg"}).reason, "emergency stop: resume first");
  EXPECT_TRUE(Ask(kWindow, ResumeRequest{}).ok);
  EXPECT_FALSE(peer_.stopped);
  EXPECT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  EXPECT_EQ(server_.Snapshot().safety.state, SnapshotSafety::State::kOn);
}

TEST_F(ControlServerTest, AcceptsAStopFromUnknownHosts) {
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  for (HostId host = 100; host < 100 + ControlServer::kMostHosts; ++host) {
    server_.OnGoal(host, {}, now_ns_);
  }
  server_.OnRequest(999, "late", 1, EmergencyStopRequest{}, now_ns_);
  EXPECT_TRUE(server_.stopped());
  EXPECT_TRUE(peer_.stopped);
  const std::vector<HostAnswer> answers = server_.TakeAnswers();
  EXPECT_TRUE(std::ranges::any_of(answers, [](const HostAnswer& answer) {
    return answer.host == 999 && answer.answer.ok;
  }));
}

TEST_F(ControlServerTest, RepeatsAReleaseUntilItTakesEffect) {
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  peer_.deaf = true;  // the simulation stands still, and its queue is full
  server_.Stop();
  Run(20, {kWindow});
  ASSERT_GE(peer_.facts.held, 0);
  peer_.deaf = false;
  Run(2, {kWindow});
  EXPECT_EQ(peer_.facts.held, -1);
  const std::size_t stated = peer_.Count(Command::Kind::kRelease);
  Run(20, {kWindow});
  EXPECT_EQ(peer_.Count(Command::Kind::kRelease), stated) << "no longer than that";
}

TEST_F(ControlServerTest, ReleasesTheClutchOfALostHost) {
  ControlServer server(peer_, true);
  server.OnScene(FourBodies(), now_ns_);
  server.OnRequest(kWindow, "window", 1, SetParameterRequest{"device_clutch", 1}, now_ns_);
  ASSERT_TRUE(peer_.workspace.clutch);
  server.Tick(now_ns_ + ControlServer::kLostNs + kMs);
  EXPECT_FALSE(peer_.workspace.clutch);
}

TEST_F(ControlServerTest, AppliesARepeatedRateOnce) {
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  HostGoal rate{.kind = HostGoal::Kind::kRate, .seq = 7};
  rate.linear.x() = 0.1;
  server_.OnGoal(kWindow, rate, now_ns_);
  const std::uint32_t seen = peer_.goal.input_seq;
  Run(ControlServer::kQuietNs / kMs + 50, {});  // quiet: the hand is held still
  server_.OnGoal(kWindow, rate, now_ns_);
  EXPECT_EQ(peer_.goal.input, GoalOrder::Input::kPose) << "an old rate does not begin again";
  EXPECT_EQ(peer_.goal.input_seq, seen + 1);
}

TEST_F(ControlServerTest, AppliesScaleViewAndClutchToADevice) {
  EXPECT_EQ(Ask(kWindow, SetParameterRequest{"device_scale", 5}).reason,
            "no device at the controller moves the hand");
  ControlServer server(peer_, true);
  server.OnScene(FourBodies(), now_ns_);
  std::uint64_t number = 0;
  const auto ask = [&](const ControlRequest& request) {
    server.OnRequest(kWindow, "window", ++number, request, now_ns_);
    const std::vector<HostAnswer> answers = server.TakeAnswers();
    return answers.size() == 1 ? answers[0].answer : Answer{false, "no answer"};
  };
  EXPECT_TRUE(ask(SetParameterRequest{"device_scale", 5}).ok);
  EXPECT_TRUE(ask(SetParameterRequest{"device_recentre", 0.2}).ok);
  EXPECT_TRUE(ask(SetParameterRequest{"device_clutch", 1}).ok);
  EXPECT_TRUE(ask(SetViewRequest{{0, 0, std::sqrt(0.5), std::sqrt(0.5)}}).ok);
  ASSERT_EQ(peer_.Count(Command::Kind::kScale), 1U);
  EXPECT_EQ(peer_.orders.back().metres, 5);
  EXPECT_EQ(peer_.workspace.recentre, 0.2);
  EXPECT_TRUE(peer_.workspace.clutch);
  // the user looks along -x: what is to the right in the picture is along y
  EXPECT_LT((peer_.workspace.q_WV * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-12);
  EXPECT_FALSE(ask(SetParameterRequest{"device_scale", 0}).ok);
  EXPECT_FALSE(ask(SetParameterRequest{"device_recentre", 0.5}).ok);
  EXPECT_FALSE(ask(SetViewRequest{{0, 0, 0, 0}}).ok);
  EXPECT_FALSE(ask(SetViewRequest{{NAN, 0, 0, 1}}).ok);
  EXPECT_EQ(peer_.Count(Command::Kind::kScale), 1U);
  // a part is taken where it was pointed at, but never while another is in hand
  server.OnRequest(kWindow, "window", ++number, GrabRequest{"peg", {{1, 2, 3}}}, now_ns_);
  EXPECT_EQ(peer_.workspace.p_WD, Vec3(1, 2, 3));
  peer_.facts.held = 1;
  server.OnFacts(peer_.facts, now_ns_);
  server.OnRequest(kWindow, "window", ++number, GrabRequest{"peg", {{4, 5, 6}}}, now_ns_);
  EXPECT_EQ(peer_.workspace.p_WD, Vec3(1, 2, 3));
}

TEST_F(ControlServerTest, HandsOverToAPeerByNameOrId) {
  EXPECT_EQ(Ask(kWindow, GiveRequest{.peer = "ben"}).reason, "the hand is empty");
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  EXPECT_EQ(Ask(kWindow, GiveRequest{.peer = "ben"}).reason, "no active peer here is called 'ben'");
  server_.OnPeers({{.id = 0xAB, .name = "ben"}, {.id = 0xCD, .name = "cleo", .active = false}});
  EXPECT_FALSE(Ask(kWindow, GiveRequest{.peer = "cleo"}).ok) << "a viewer holds nothing";
  EXPECT_TRUE(Ask(kWindow, GiveRequest{.peer = "00000000000000ab"}).ok);
  EXPECT_EQ(peer_.orders.back().to, 0xABU);
}

TEST_F(ControlServerTest, AcceptsOnlyParametersInRange) {
  EXPECT_TRUE(Ask(kWindow, SetParameterRequest{"hand_force_N", 5}).ok);
  EXPECT_EQ(peer_.goal.limits.force, 5.0);
  EXPECT_FALSE(Ask(kWindow, SetParameterRequest{"hand_force_N", 31}).ok) << "no hand has more";
  EXPECT_FALSE(Ask(kWindow, SetParameterRequest{"hand_force_N", -1}).ok);
  EXPECT_EQ(peer_.goal.limits.force, 5.0);
  EXPECT_FALSE(Ask(kWindow, SetParameterRequest{"gravity", 1}).ok);
}

TEST_F(ControlServerTest, SnapshotRateIsTheHighestRequested) {
  EXPECT_EQ(server_.rate_hz(), 0.0);
  ASSERT_TRUE(Ask(kWindow, SnapshotRateRequest{30}).ok);
  ASSERT_TRUE(Ask(kScript, SnapshotRateRequest{500}).ok);
  EXPECT_EQ(server_.rate_hz(), 500.0);
  EXPECT_FALSE(Ask(kScript, SnapshotRateRequest{2000}).ok);
  Run(600, {kWindow});
  EXPECT_EQ(server_.rate_hz(), 30.0);
}

TEST_F(ControlServerTest, RepeatedRequestIsExecutedOnce) {
  ASSERT_TRUE(Ask(kWindow, GrabRequest{.body = "peg"}).ok);
  server_.OnRequest(kWindow, "window", number_, GrabRequest{.body = "bolt"}, now_ns_);
  Run(10, {kWindow});
  EXPECT_EQ(peer_.facts.held, 0);
}

TEST_F(ControlServerTest, LongRequestsAreAnsweredOnCompletion) {
  EXPECT_EQ(Ask(kWindow, LoadSceneRequest{.file = "other"}).reason, "no answer");
  ASSERT_EQ(peer_.jobs.size(), 1U);
  server_.OnScene(std::nullopt, now_ns_);
  EXPECT_EQ(Ask(kScript, GrabRequest{.body = "peg"}).reason, "the scene is being loaded");
  ControlScene other = FourBodies();
  other.number = 2;
  server_.OnScene(other, now_ns_);
  server_.OnDone(peer_.jobs[0].first, {true, ""});
  Run(1, {kWindow});
  EXPECT_EQ(answers_.back().host, kWindow);
  EXPECT_TRUE(answers_.back().answer.ok);
  EXPECT_EQ(server_.Snapshot().scene_number, 2U);
}

TEST_F(ControlServerTest, RefusesHostsBeyondItsCapacity) {
  for (HostId host = 100; host < 100 + ControlServer::kMostHosts; ++host) {
    server_.OnGoal(host, {}, now_ns_);
  }
  server_.OnRequest(kWindow, "window", 1, ReleaseRequest{}, now_ns_);
  const std::vector<HostAnswer> answers = server_.TakeAnswers();
  ASSERT_EQ(answers.size(), 1U);
  EXPECT_EQ(answers[0].answer.reason, "the controller has 8 hosts, the most there are");
}

TEST_F(ControlServerTest, PersonAtTheControllerIsToldWhoSavesLoadsResumesAndQuits) {
  Send(kWindow, SaveRequest{"/a/b\x1b[2J.json"});
  Send(kScript, LoadSceneRequest{"/a/c.json"});
  Send(kScript, LoadMeshRequest{.file = "/a/d.stl"});
  Send(kScript, ResumeRequest{});
  server_.Stop();
  Send(kScript, ResumeRequest{});
  Send(kWindow, QuitRequest{});
  EXPECT_EQ(
      server_.TakeLines(),
      (std::vector<std::string>{
          "the host 'window' saves the scene: /a/b?[2J.json", "the host 'script' loads /a/c.json",
          "the host 'script' adds /a/d.stl", "the host 'script' ends the emergency stop",
          "the host 'window' ends the controller"}));
  // ten lines a second, whatever hosts ask for
  now_ns_ += 1'000'000'000;
  for (int i = 0; i < 1000; ++i) Send(kScript, SaveRequest{"/a/e.json"});
  EXPECT_EQ(server_.TakeLines().size(), 10U);
}

}  // namespace
}  // namespace tandem
