#pragma once

#include <cstdint>
#include <string>
#include <vector>

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

/// Floods for so long. Returns how many samples or packets were sent. The kinds by DDS join the
/// session as a program of its own that keeps to none of the product's checks; the last sends to
/// the loopback's ports of the options' domain, those of the first few programs.
Result<std::uint64_t> Flood(Attack attack, const DdsOptions& options, double seconds);

}  // namespace tandem
