#pragma once

#include <cstdint>
#include <string>

#include "collab/dds/dds_api.h"
#include "collab/dds/writer_gate.h"

namespace tandem {

/// What a topic is for.
enum class Purpose : std::uint8_t {
  kMotion,    // state/1, link/2, view/1: the newest, late is lost
  kPresence,  // peer_info: kept for those who come later; its silence is noticed within
              // kLivelinessLeaseNs
  kSubject,   // scene: kept for those who come later
  kEvent      // event: each, in order; not kept
};

/// How long a peer may be silent before the others take it for lost. Both ends announce it.
inline constexpr std::int64_t kLivelinessLeaseNs = 600'000'000;

/// The quality of service of a topic's readers and writers alike. Samples of the own participant
/// are never delivered. Writers do not dispose of their instances when deleted: a disposed instance
/// is a goodbye, one without writers is a loss.
Qos MakeQos(Purpose purpose, const std::string& partition);

/// What the writers of such a topic may send. `behind_relay`: one program speaks for many peers.
WriterLimits LimitsOf(Purpose purpose, bool behind_relay);

}  // namespace tandem
