#include "app/join/reach_inviter.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "app/join/discover_sessions.h"
#include "collab/dds/transport/announcements.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr std::int64_t kHearInviterNs = 2000 * kMs;  // for the session's announcement here
constexpr const char* kLoopbackAddress = "127.0.0.1";

}  // namespace

InviterSearch::InviterSearch(Invitation invitation, ConnectionOptions& connection)
    : invitation_(std::move(invitation)) {
  connection.domain = invitation_.domain;
  if (!connection.peers.empty()) return;  // peers from the options count
  const bool this_machine = std::ranges::all_of(invitation_.hosts, [](const std::string& host) {
    return host.substr(0, host.find(':')) == kLoopbackAddress;
  });
  if (this_machine) {
    if (connection.interface.empty()) connection.interface = "lo";
    return;
  }
  DdsOptions dds;
  ApplyConnection(connection, dds);
  nearby_ = ListenForSessions(dds);
  until_ns_ = MonotonicNowNs() + kHearInviterNs;
}

void InviterSearch::End(ConnectionOptions& connection) {
  if (!nearby_) return;
  const AnnouncedSession wanted{invitation_.session, invitation_.secured};
  bool received = false;
  DiscoverSessions(*nearby_, until_ns_, [&](const std::vector<AnnouncedSession>& sessions) {
    received = std::ranges::find(sessions, wanted) != sessions.end();
    return received;
  });
  nearby_.reset();
  if (received) return;
  connection.peers = invitation_.hosts;
  connection.peers.insert(connection.peers.end(), invitation_.others.begin(),
                          invitation_.others.end());
}

void ReachInviter(const Invitation& invitation, ConnectionOptions& connection) {
  InviterSearch(invitation, connection).End(connection);
}

}  // namespace tandem
