#pragma once

#include <set>
#include <string>
#include <vector>

#include "collab/dds/packet_filter.h"

namespace tandem {

/// Tells a user once of each kind of packet that DDS did not get to see since there were too many.
/// Whose they are nobody knows. What is refused of a program's samples PeerDirectory tells.
class RefusalNews {
 public:
  /// Fewer of a kind are an accident: a program that starts, or ends.
  static constexpr std::uint64_t kLeastPackets = 200;

  /// What is new since the last call.
  std::vector<std::string> Look(const PacketCounts& packets);

 private:
  std::set<PacketDrop> packets_told_;
};

}  // namespace tandem
