#pragma once

#include <cstdint>
#include <string>

#include "collab/dds/transport/dds_transport.h"
#include "engine/base/result.h"

namespace tandem {

/// A flood of one's own session, to measure its effect (tandem bench hostile).
enum class Attack : std::uint8_t {
  kStates,   // sound states of one body, as fast as possible
  kKeys,     // states of new bodies, without end
  kNames,    // presence under new names, without end
  kPackets,  // announcements of new programs, without end, by a plain socket
  kCount
};
const char* NameOf(Attack attack) noexcept;  // "states" …
Result<Attack> AttackNamed(const std::string& name);

/// The length of a flood and its density.
struct FloodPlan {
  double seconds = 0;
  std::uint64_t most = 0;  // number of samples or packets that ends it earlier; 0: no such number
  double per_second = 0;   // rate of samples or packets; 0: as many as possible
};

/// Floods as planned and returns how many samples or packets were sent. The attacks over DDS join
/// the session as a separate program that does none of the product's checks. kPackets sends to the
/// discovery ports of all programs of the options' domain on loopback.
Result<std::uint64_t> Flood(Attack attack, const DdsOptions& options, const FloodPlan& plan);

}  // namespace tandem
