#include "collab/session/sessions_nearby.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(SessionsNearby, EmptySessionSuggestsCausesAndOtherSessions) {
  const AnnouncedSession plain{"press", false};
  EXPECT_EQ(
      NobodyHeard(plain, {}),
      "no peer answers in session press: is its name, network, domain or --secure another one?");
  EXPECT_EQ(NobodyHeard(plain, {{"pres", false}, {"gear", true}}),
            "no peer answers in session press; announced here: pres, gear (secured)");
  EXPECT_EQ(
      NobodyHeard({"press/view", false}, {{"gear/view", true}}),
      "no peer answers in session the relay of press; announced here: the relay of gear (secured)");
}

TEST(SessionsNearby, MissingOrWrongKeysAreReported) {
  EXPECT_EQ(
      NobodyHeard({"press", false}, {{"gear", false}, {"press", true}}),
      "no peer answers in session press: it is secured, and needs a viewer's keys (--secure)");
  EXPECT_EQ(
      NobodyHeard({"press", true}, {{"press", false}}),
      "no peer answers in session press: it is plain, but you came with keys: leave --secure out");
  EXPECT_EQ(NobodyHeard({"press", true}, {{"press", true}}),
            "no peer answers in session press: others are in it, but their keys and yours are not "
            "of the same session");
  // somebody is about to be heard in a plain session, or only its announcement gets through
  EXPECT_EQ(
      NobodyHeard({"press", false}, {{"press", false}}),
      "no peer answers in session press: is its name, network, domain or --secure another one?");
}

}  // namespace
}  // namespace tandem
