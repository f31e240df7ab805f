#pragma once

#include <cstdint>
#include <string>

#include "collab/dds/dds_transport.h"
#include "engine/base/result.h"

namespace tandem {

/// A flood of a session that is one's own, to measure what it does (tandem bench hostile).
enum class Attack : std::uint8_t {
  kStates,   // sound states of one body, as fast as can be
  kKeys,     // states of ever new bodies
  kNames,    // presence under ever new names
  kPackets,  // announcements of ever new programs, by a plain socket
  kCount
};
const char* NameOf(Attack attack) noexcept;  // "states" …
Result<Attack> AttackNamed(const std::string& name);

/// How long a flood lasts, and how dense it is.
struct FloodPlan {
  double seconds = 0;
  std::uint64_t most = 0;  // samples or packets after which it ends earlier; 0: no such number
  double per_second = 0;   // samples or packets; 0: as many as can be
};

/// Floods as planned. Returns how many samples or packets were sent. The kinds by DDS join the
/// session as a program of its own that keeps to none of the product's checks; the last sends to
/// the loopback's ports of the options' domain, those of all programs that are there.
Result<std::uint64_t> Flood(Attack attack, const DdsOptions& options, const FloodPlan& plan);

}  // namespace tandem
