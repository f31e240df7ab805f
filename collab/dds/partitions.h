#pragma once

#include <array>
#include <atomic>
#include <string>
#include <string_view>

#include "collab/dds/dds_api.h"
#include "collab/messages.h"

namespace tandem {

inline constexpr const char* kEveryPeer = "peer.*";
inline constexpr const char* kEveryView = "view.*";
inline constexpr const char* kScenePartition = "scene";

std::string PeerPartition(PeerId peer);  // of state/1, link/2, peer_info
std::string ViewPartition(PeerId peer);  // of view/1

/// Whose partition it is; 0 where it is nobody's.
PeerId OwnerOfPartition(std::string_view partition);

/// In whose partition, and no other's, a writer publishes what `reader` gets of it; 0 when not
/// known (any more). Only so much of a peer's identity do DDS permissions protect, so a sample
/// counts as its peer's only if it came this way.
PeerId OwnerOfWriter(dds_entity_t reader, dds_instance_handle_t writer);

/// Whose the writers that match a reader are. Written by the control thread, read by the receive
/// thread. Of more than it has places for, those that came first keep theirs: a flood of newcomers
/// mutes nobody who is known.
class WriterOwners {
 public:
  /// Of a writer in more than one partition, or in none of a peer's.
  static constexpr PeerId kNobody = ~PeerId{0};

  /// The writers of a crashed peer stay until its lease ends, beside those of its successor.
  static constexpr std::size_t kMaxWriters = 16 * kMaxPeers;

  /// Gives how many found no place: they are not heard.
  std::size_t Refresh(dds_entity_t reader);
  PeerId Find(dds_instance_handle_t writer) const noexcept;  // 0: not known (yet)

 private:
  struct Slot {
    std::atomic<dds_instance_handle_t> writer =
        0;  // never used for two writers in a process's life
    std::atomic<PeerId> owner = 0;
  };

  bool Add(dds_instance_handle_t writer, PeerId owner);

  std::array<Slot, kMaxWriters> slots_;
};

}  // namespace tandem
