#include "app/join/hear_sessions.h"

#include <chrono>
#include <memory>

#include "app/common/stop_signal.h"
#include "collab/dds/transport/announcements.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

constexpr std::int64_t kHearNs = 50'000'000;

}  // namespace

std::vector<AnnouncedSession> HearSessions(
    const ReachOptions& reach, double seconds,
    const std::function<bool(const std::vector<AnnouncedSession>&)>& enough) {
  DdsOptions dds;
  ApplyReach(reach, dds);
  const std::unique_ptr<SessionsNearby> nearby = ListenForSessions(dds);
  return HearSessions(*nearby, MonotonicNowNs() + static_cast<std::int64_t>(1e9 * seconds), enough);
}

std::vector<AnnouncedSession> HearSessions(
    SessionsNearby& nearby, std::int64_t until_ns,
    const std::function<bool(const std::vector<AnnouncedSession>&)>& enough) {
  StopOnSignals();
  for (;;) {
    const std::vector<AnnouncedSession> heard = nearby.Heard();
    if (MonotonicNowNs() >= until_ns || enough(heard)) return heard;
    if (StopAskedWithin(std::chrono::nanoseconds(kHearNs))) return heard;
  }
}

}  // namespace tandem
