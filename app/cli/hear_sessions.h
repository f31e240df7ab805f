#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "app/reach/reach_options.h"
#include "collab/sessions_nearby.h"

namespace tandem {

/// Listens for sessions that are announced, so long at the most (s), or until `enough` of what was
/// heard or a signal comes.
std::vector<AnnouncedSession> HearSessions(
    const ReachOptions& reach, double seconds,
    const std::function<bool(const std::vector<AnnouncedSession>&)>& enough);

/// The same with a listener that is there already, until that time.
std::vector<AnnouncedSession> HearSessions(
    SessionsNearby& nearby, std::int64_t until_ns,
    const std::function<bool(const std::vector<AnnouncedSession>&)>& enough);

}  // namespace tandem
