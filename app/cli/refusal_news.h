#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/peer_table_text.h"
#include "collab/dds/packet_filter.h"
#include "collab/drop_counts.h"

namespace tandem {

/// Tells a user once of each program, and of each bound, that it sends more than is taken.
class RefusalNews {
 public:
  /// Fewer of a kind are an accident: a program that starts, or ends.
  static constexpr std::uint64_t kLeast = 20;
  static constexpr std::uint64_t kLeastPackets = 200;
  static constexpr std::size_t kMostTold = 64;

  /// What is new since the last call.
  std::vector<std::string> Look(const DropTable& drops, const NameFunction& name);
  /// The same of packets that DDS did not get to see. Whose they are nobody knows.
  std::vector<std::string> Look(const PacketCounts& packets);

 private:
  std::set<std::pair<PeerId, Drop>> told_;
  std::set<PacketDrop> packets_told_;
};

}  // namespace tandem
