#pragma once

#include <set>
#include <string>
#include <vector>

#include "collab/dds/transport/packet_filter.h"

namespace tandem {

/// Tells a user once of each kind of packet that was refused before DDS because there were too
/// many. Nobody knows who sent them. PeerDirectory tells of a program's samples that are refused.
class RefusalNotifier {
 public:
  /// Fewer packets of a kind are an accident: a program starts, or ends.
  static constexpr std::uint64_t kLeastPackets = 200;

  /// Returns the notifications since the last call.
  std::vector<std::string> TakeNotifications(const PacketCounts& packets);

 private:
  std::set<PacketDrop> packets_told_;
};

}  // namespace tandem
