#include "app/join/reach_inviter.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "app/join/hear_sessions.h"
#include "collab/dds/transport/announcements.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr std::int64_t kHearInviterNs = 2000 * kMs;  // for the session's announcement here
constexpr const char* kLoopbackAddress = "127.0.0.1";

}  // namespace

InviterSearch::InviterSearch(Invitation invitation, ReachOptions& reach)
    : invitation_(std::move(invitation)) {
  reach.domain = invitation_.domain;
  if (!reach.peers.empty()) return;  // peers from the options count
  const bool this_machine = std::ranges::all_of(invitation_.hosts, [](const std::string& host) {
    return host.substr(0, host.find(':')) == kLoopbackAddress;
  });
  if (this_machine) {
    if (reach.interface.empty()) reach.interface = "lo";
    return;
  }
  DdsOptions dds;
  ApplyReach(reach, dds);
  nearby_ = ListenForSessions(dds);
  until_ns_ = MonotonicNowNs() + kHearInviterNs;
}

void InviterSearch::End(ReachOptions& reach) {
  if (!nearby_) return;
  const AnnouncedSession wanted{invitation_.session, invitation_.secured};
  bool heard = false;
  HearSessions(*nearby_, until_ns_, [&](const std::vector<AnnouncedSession>& sessions) {
    heard = std::ranges::find(sessions, wanted) != sessions.end();
    return heard;
  });
  nearby_.reset();
  if (heard) return;
  reach.peers = invitation_.hosts;
  reach.peers.insert(reach.peers.end(), invitation_.others.begin(), invitation_.others.end());
}

void ReachInviter(const Invitation& invitation, ReachOptions& reach) {
  InviterSearch(invitation, reach).End(reach);
}

}  // namespace tandem
