#include "app/join/reach_inviter.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "collab/dds/transport/dds_transport.h"
#include "collab/session/early_inbox.h"

namespace tandem {
namespace {

Invitation ToASession() {
  Invitation invitation;
  invitation.session = "reach-inviter-" + std::to_string(getpid());
  invitation.hosts = {"192.0.2.1:17910"};
  invitation.others = {"192.0.2.7"};
  return invitation;
}

// The session is gone again when its search ends, so that only what came before tells of it.
TEST(InviterSearch, UsesAnEarlierAnnouncement) {
  const Invitation invitation = ToASession();
  ReachOptions reach;
  reach.interface = "lo";
  InviterSearch search(invitation, reach);
  {
    EarlyInbox inbox;
    DdsOptions options;
    options.session = invitation.session;
    options.peer = 7;
    ApplyReach(reach, options);
    const auto joined = JoinOverDds(options, inbox);
    ASSERT_TRUE(joined) << joined.error().what;
  }
  search.End(reach);
  EXPECT_THAT(reach.peers, ::testing::IsEmpty());
}

TEST(InviterSearch, TriesTheInvitationsHostsWithoutAnAnnouncement) {
  ReachOptions reach;
  reach.interface = "lo";
  InviterSearch(ToASession(), reach).End(reach);
  EXPECT_THAT(reach.peers, ::testing::ElementsAre("192.0.2.1:17910", "192.0.2.7"));
}

TEST(InviterSearch, KeepsManuallyNamedPeers) {
  Invitation invitation = ToASession();
  invitation.domain = 77;
  ReachOptions reach;
  reach.peers = {"198.51.100.3"};
  InviterSearch(invitation, reach).End(reach);
  EXPECT_THAT(reach.peers, ::testing::ElementsAre("198.51.100.3"));
  EXPECT_EQ(reach.domain, 77U);
}

}  // namespace
}  // namespace tandem
