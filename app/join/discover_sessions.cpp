#include "app/join/discover_sessions.h"

#include <chrono>
#include <memory>

#include "app/common/stop_signal.h"
#include "collab/dds/transport/announcements.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr std::int64_t kHearNs = 50'000'000;

}  // namespace

std::vector<AnnouncedSession> DiscoverSessions(
    const ConnectionOptions& connection, double seconds,
    const std::function<bool(const std::vector<AnnouncedSession>&)>& enough) {
  DdsOptions dds;
  ApplyConnection(connection, dds);
  const std::unique_ptr<SessionsNearby> nearby = ListenForSessions(dds);
  return DiscoverSessions(*nearby, MonotonicNowNs() + static_cast<std::int64_t>(1e9 * seconds),
                          enough);
}

std::vector<AnnouncedSession> DiscoverSessions(
    SessionsNearby& nearby, std::int64_t until_ns,
    const std::function<bool(const std::vector<AnnouncedSession>&)>& enough) {
  StopOnSignals();
  for (;;) {
    const std::vector<AnnouncedSession> received = nearby.Heard();
    if (MonotonicNowNs() >= until_ns || enough(received)) return received;
    if (StopRequestedWithin(std::chrono::nanoseconds(kHearNs))) return received;
  }
}

}  // namespace tandem
