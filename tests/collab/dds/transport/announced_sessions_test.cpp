#include <algorithm>

#include <gmock/gmock.h>

#include "collab/dds/security/keys.h"
#include "collab/dds/transport/announcements.h"
#include "engine/realtime/clock.h"
#include "tests/collab/dds/child_peer.h"
#include "tests/collab/dds/live_peer.h"
#include "tests/support/scratch_folder.h"

namespace tandem::testing {
namespace {

/// Returns whether the session is heard of within some seconds; an announcement comes every 1.6 s.
bool Hears(SessionsNearby& nearby, const AnnouncedSession& session) {
  const std::int64_t until_ns = MonotonicNowNs() + 10'000'000'000;
  while (MonotonicNowNs() < until_ns) {
    const std::vector<AnnouncedSession> received = nearby.Heard();
    if (std::find(received.begin(), received.end(), session) != received.end()) return true;
    MachineClock().SleepUntil(MonotonicNowNs() + 20'000'000);
  }
  return false;
}

TEST(AnnouncedSessions, OtherSessionsAreListedAndTheOwnSessionIsNot) {
  const std::string there = RandomSession();
  const std::string here = RandomSession();
  ChildPeer other(there, 22);
  Recorder received;
  const DdsOptions options = LoopbackOptions(here, 7, Role::kViewer);
  const auto joined = JoinOverDds(options, received);
  ASSERT_TRUE(joined) << joined.error().what;
  const auto nearby = ListenForSessions(options);
  EXPECT_TRUE(Hears(*nearby, {there, false}));
  const std::vector<AnnouncedSession> all = nearby->Heard();
  EXPECT_THAT(all, ::testing::Not(::testing::Contains(AnnouncedSession{here, false})));
  EXPECT_TRUE(received.Now().infos.empty());  // nothing else of another session is heard
  (*joined)->Leave();
}

TEST(AnnouncedSessions, SecuredSessionIsRecognizedWithoutKeys) {
  const ScratchFolder folder;
  const std::filesystem::path keys = folder.path() / "keys";
  ASSERT_TRUE(MakeSessionKeys(keys));
  const Result<PeerId> anna = MakeMemberKeys(keys, "anna", Role::kActive, keys / "anna");
  ASSERT_TRUE(anna) << anna.error().what;
  const std::string session = RandomSession();
  ChildPeer other(session, *anna, {.secure = keys / "anna"});
  Recorder received;
  const DdsOptions options = LoopbackOptions(session, 7, Role::kViewer);
  const auto joined = JoinOverDds(options, received);
  ASSERT_TRUE(joined) << joined.error().what;
  const auto nearby = ListenForSessions(options);
  EXPECT_TRUE(Hears(*nearby, {session, true}));
  EXPECT_TRUE(received.Now().infos.empty());
  (*joined)->Leave();
}

}  // namespace
}  // namespace tandem::testing
