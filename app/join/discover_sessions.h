#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "app/connection/connection_options.h"
#include "collab/session/sessions_nearby.h"

namespace tandem {

/// Listens for announced sessions for `seconds` at most. Returns earlier if `enough` is true for
/// the sessions heard, or on a signal.
std::vector<AnnouncedSession> DiscoverSessions(
    const ConnectionOptions& connection, double seconds,
    const std::function<bool(const std::vector<AnnouncedSession>&)>& enough);

/// Listens by a listener that is there already, until `until_ns`.
std::vector<AnnouncedSession> DiscoverSessions(
    SessionsNearby& nearby, std::int64_t until_ns,
    const std::function<bool(const std::vector<AnnouncedSession>&)>& enough);

}  // namespace tandem
