#pragma once

#include <cstdint>
#include <string>

#include "collab/dds/cyclone/dds_api.h"
#include "collab/dds/cyclone/writer_rate_limiter.h"

namespace tandem {

/// The purpose of a topic.
enum class Purpose : std::uint8_t {
  kMotion,    // state/1, link/2, view/1: only the newest counts, late samples are lost
  kPresence,  // peer_info: kept for latecomers; its silence is noticed within kLivelinessLeaseNs
  kSubject,   // scene: kept for latecomers
  kEvent      // event: every sample, in order; not kept
};

/// Time for which a peer may be silent before the others take it for lost. Both ends announce it.
inline constexpr std::int64_t kLivelinessLeaseNs = 600'000'000;

/// Returns the quality of service for a topic's readers and writers alike. Samples of the own
/// participant are never delivered. Writers do not dispose of their instances when deleted: a
/// disposed instance is a goodbye, an instance without writers is a loss.
Qos MakeQos(Purpose purpose, const std::string& partition);

/// Returns the limits for writers of such a topic. `behind_relay`: one program speaks for many
/// peers.
WriterLimits LimitsOf(Purpose purpose, bool behind_relay);

}  // namespace tandem
