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
  ConnectionOptions connection;
  connection.interface = "lo";
  InviterSearch search(invitation, connection);
  {
    EarlyInbox inbox;
    DdsOptions options;
    options.session = invitation.session;
    options.peer = 7;
    ApplyConnection(connection, options);
    const auto joined = JoinOverDds(options, inbox);
    ASSERT_TRUE(joined) << joined.error().what;
  }
  search.End(connection);
  EXPECT_THAT(connection.peers, ::testing::IsEmpty());
}

TEST(InviterSearch, TriesTheInvitationsHostsWithoutAnAnnouncement) {
  ConnectionOptions connection;
  connection.interface = "lo";
  InviterSearch(ToASession(), connection).End(connection);
  EXPECT_THAT(connection.peers, ::testing::ElementsAre("192.0.2.1:17910", "192.0.2.7"));
}

TEST(InviterSearch, KeepsManuallyNamedPeers) {
  Invitation invitation = ToASession();
  invitation.domain = 77;
  ConnectionOptions connection;
  connection.peers = {"198.51.100.3"};
  InviterSearch(invitation, connection).End(connection);
  EXPECT_THAT(connection.peers, ::testing::ElementsAre("198.51.100.3"));
  EXPECT_EQ(connection.domain, 77U);
}

}  // namespace
}  // namespace tandem
