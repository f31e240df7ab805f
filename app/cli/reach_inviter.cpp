#include "app/cli/reach_inviter.h"

#include <algorithm>
#include <string>
#include <vector>

#include "app/cli/hear_sessions.h"

namespace tandem {
namespace {

constexpr double kHearInviter = 2;  // s, for the session on this network
constexpr const char* kLoopbackAddress = "127.0.0.1";

}  // namespace

void ReachInviter(const Invitation& invitation, ReachOptions& reach) {
  reach.domain = invitation.domain;
  if (!reach.peers.empty()) return;  // told by hand
  const bool this_machine = std::ranges::all_of(invitation.hosts, [](const std::string& host) {
    return host.substr(0, host.find(':')) == kLoopbackAddress;
  });
  if (this_machine) {
    if (reach.interface.empty()) reach.interface = "lo";
    return;
  }
  const AnnouncedSession wanted{invitation.session, invitation.secured};
  bool heard = false;
  HearSessions(reach, kHearInviter, [&](const std::vector<AnnouncedSession>& sessions) {
    heard = std::ranges::find(sessions, wanted) != sessions.end();
    return heard;
  });
  if (heard) return;
  reach.peers = invitation.hosts;
  reach.peers.insert(reach.peers.end(), invitation.others.begin(), invitation.others.end());
}

}  // namespace tandem
