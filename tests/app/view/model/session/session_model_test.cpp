#include "app/view/model/session/session_model.h"

#include <future>

#include <gtest/gtest.h>

#include "tests/app/view/fake_session.h"

namespace tandem {
namespace {

TEST(SessionModel, JoinsWithoutBlockingAsANamedViewer) {
  FakeSession fake;
  std::promise<void> network_answers;
  SessionModel session([&](const JoinRequest& request, PeerId peer, Inbox& inbox) {
    network_answers.get_future().wait();
    return fake.Join()(request, peer, inbox);
  });
  EXPECT_EQ(session.state(), SessionModel::State::kIdle);
  session.Join({"bracket", "Dora", 43, "lo"});  // returns though the network has not answered
  EXPECT_EQ(session.state(), SessionModel::State::kJoining);
  network_answers.set_value();
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kJoined;
  }));
  EXPECT_EQ(fake.request.session, "bracket");
  EXPECT_EQ(fake.request.domain, 43U);
  EXPECT_EQ(fake.request.interface, "lo");
  ASSERT_FALSE(fake.output.empty());
  EXPECT_EQ(fake.output[0].name, "Dora");
  EXPECT_EQ(fake.output[0].role, Role::kViewer);
  EXPECT_EQ(fake.output[0].peer, fake.peer);
  EXPECT_NE(fake.peer, 0U);
}

TEST(SessionModel, AnnouncesItselfPeriodically) {
  FakeSession fake;
  SessionModel session(fake.Join());
  session.Join({"s", "Dora", 42, ""});
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return fake.output.size() >= 3;
  }));
  EXPECT_LT(fake.output[0].beat, fake.output[2].beat);
}

TEST(SessionModel, ReportsAFailedJoinAndCanRetry) {
  FakeSession fake;
  fake.refuse = "no interface called eth7";
  SessionModel session(fake.Join());
  session.Join({"s", "Dora", 42, "eth7"});
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kFailed;
  }));
  EXPECT_EQ(session.error(), "no interface called eth7");
  fake.refuse.clear();
  session.Join({"s", "Dora", 42, ""});
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kJoined;
  }));
  EXPECT_TRUE(session.error().isEmpty());
}

TEST(SessionModel, LeaveKeepsTheLastPictureAndAllowsARejoin) {
  FakeSession fake;
  SessionModel session(fake.Join());
  session.Join({"s", "Dora", 42, ""});
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kJoined;
  }));
  fake.inbox->OnView(FakeSession::Frame(5, 1, Vec3(0.1, 0, 0), 104), 0);
  EXPECT_EQ(session.Picture().peers.at(0).presence, ViewedPeer::Presence::kHere);

  fake.inbox->OnPeerInfo(FakeSession::Info(6, "Ben", Role::kActive), 0);
  fake.inbox->OnPeerLeft(6);
  session.Leave();
  EXPECT_EQ(session.state(), SessionModel::State::kLeft);
  EXPECT_EQ(fake.left, 1);
  EXPECT_EQ(fake.destroyed, 1);
  // a peer that was here may be so still; a peer that had left has left
  EXPECT_EQ(session.Picture().peers.at(0).presence, ViewedPeer::Presence::kUnknown);
  EXPECT_EQ(session.Picture().peers.at(1).presence, ViewedPeer::Presence::kLeft);
  EXPECT_EQ(session.Picture().samples, 1U);

  session.Join({"s", "Dora", 42, ""});
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kJoined;
  }));
  EXPECT_TRUE(session.Picture().peers.empty());
}

TEST(SessionModel, LeavesAndReportsWhenItsKeysExpire) {
  FakeSession fake;
  SessionModel session(fake.Join());
  session.Join({"s", "Dora", 42, ""});
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kJoined;
  }));
  EXPECT_EQ(fake.left, 0);
  fake.keys_end = "the keys of Dora have ended";
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kLeft;
  }));
  EXPECT_EQ(fake.left, 1);
  EXPECT_EQ(session.error(), "the keys of Dora have ended");

  // nor is it in a session whose keys end as it joins
  session.Join({"s", "Dora", 42, ""});
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kLeft;
  }));
  EXPECT_EQ(fake.left, 2);
}

/// Other sessions, which a test sets.
struct FakeNearby : SessionsNearby {
  explicit FakeNearby(const std::vector<AnnouncedSession>& s) : sessions(s) {}
  std::vector<AnnouncedSession> Heard() override { return sessions; }
  const std::vector<AnnouncedSession>& sessions;
};

TEST(SessionModel, EmptySessionListsOtherSessions) {
  FakeSession fake;
  std::vector<AnnouncedSession> others;
  SessionModel session(fake.Join(), [&](const JoinRequest& request) {
    EXPECT_EQ(request.session, "bracket");
    return std::make_unique<FakeNearby>(others);
  });
  session.Join({"bracket", "Dora", 42, ""});
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kJoined;
  }));
  EXPECT_FALSE(session.has_peers());
  EXPECT_EQ(session.nobody_heard(), "no peer answers yet in session bracket");
  others = {{"brackets", true}};
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.nobody_heard().contains("brackets (secured)");
  }));
  others.clear();  // and it has ended
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.nobody_heard().contains("is its name, network, domain or keys another one?");
  }));
  int changes = 0;
  QObject::connect(&session, &SessionModel::StateChanged, [&] {
    ++changes;
  });
  fake.inbox->OnPeerInfo(FakeSession::Info(6, "Ben", Role::kActive), 0);
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.has_peers();
  }));
  EXPECT_EQ(changes, 1);
  EXPECT_TRUE(session.nobody_heard().isEmpty());
  // nobody has been heard of the next session that is joined
  session.Leave();
  session.Join({"bracket", "Dora", 42, ""});
  EXPECT_FALSE(session.has_peers());
  ASSERT_TRUE(ProcessEventsUntil([&] {
    return session.state() == SessionModel::State::kJoined;
  }));
}

TEST(SessionModel, DestructionSaysGoodbyeDuringAJoin) {
  FakeSession joined;
  {
    SessionModel session(joined.Join());
    session.Join({"s", "Dora", 42, ""});
    ASSERT_TRUE(ProcessEventsUntil([&] {
      return session.state() == SessionModel::State::kJoined;
    }));
  }
  EXPECT_EQ(joined.left, 1);
  FakeSession setup;
  {
    SessionModel session(setup.Join());
    session.Join({"s", "Dora", 42, ""});
  }
  EXPECT_EQ(setup.left, 1);
  EXPECT_EQ(setup.destroyed, 1);
}

}  // namespace
}  // namespace tandem
