#pragma once

#include <array>
#include <atomic>
#include <map>
#include <string>
#include <string_view>

#include "collab/dds/dds_api.h"
#include "collab/messages.h"

namespace tandem {

inline constexpr const char* kEveryPeer = "peer.*";
inline constexpr const char* kEveryView = "view.*";
inline constexpr const char* kEveryScene = "scene.*";
inline constexpr const char* kEveryViewer = "viewer.*";

std::string PeerPartition(PeerId peer);    // of state/1, link/2, event, peer_info
std::string ViewPartition(PeerId peer);    // of view/1
std::string ScenePartition(PeerId peer);   // of scene
std::string ViewerPartition(PeerId peer);  // of viewer_info

/// Of peer_info and viewer_info of a secured session: the name is part of it, so that permissions
/// bind it too; what no member's name has becomes '_'.
std::string NamedPartition(const std::string& partition, const std::string& name);

/// What a partition says of whoever publishes in it.
struct PartitionOwner {
  PeerId peer = 0;   // 0: it is nobody's
  std::string name;  // empty: it has none

  friend bool operator==(const PartitionOwner&, const PartitionOwner&) = default;
};
PartitionOwner OwnerOfPartition(std::string_view partition);

/// Who stands behind a writer as far as DDS knows: in whose partition, and no other's, it publishes
/// what `reader` gets of it, and which participant it is of. Only so much of a peer's identity do
/// DDS permissions protect, so a sample counts as its peer's only if it came this way.
struct WriterFacts {
  PartitionOwner owner;                   // nobody: not known (any more), or in several partitions
  dds_instance_handle_t participant = 0;  // 0: not known (any more)
};
WriterFacts FactsOfWriter(dds_entity_t reader, dds_instance_handle_t writer);

/// Which participant speaks for each peer that is here: whoever was heard first as that peer, until
/// it is gone. What others publish in that peer's partitions is not the peer's. In a secured
/// session permissions see to this; in a plain one nothing else does. Used by the control thread.
using Seats = std::map<PeerId, dds_instance_handle_t>;

/// Whose the writers that match a reader are. Written by the control thread, read by the receive
/// thread. Of more than it has places for, those that came first keep theirs: a flood of newcomers
/// mutes nobody who is known.
class WriterOwners {
 public:
  /// Of a writer in more than one partition, or in none of a peer's.
  static constexpr PeerId kNobody = ~PeerId{0};

  /// The writers of a crashed peer stay until its lease ends, beside those of its successor.
  static constexpr std::size_t kMaxWriters = 16 * kMaxPeers;
  static constexpr std::size_t kMaxOfOne = 4;  // in one peer's partition

  /// Gives how many found no place: they are not heard. Writers in a partition whose peer has
  /// another participant's seat are nobody's.
  std::size_t Refresh(dds_entity_t reader, const Seats& seats = {});
  PeerId Find(dds_instance_handle_t writer) const noexcept;  // 0: not known (yet)

 private:
  struct Slot {
    std::atomic<dds_instance_handle_t> writer =
        0;  // never used for two writers in a process's life
    std::atomic<PeerId> owner = 0;
    WriterFacts facts;  // the control thread's
  };

  bool Has(dds_instance_handle_t writer) const noexcept;
  /// Gives it a place, unless there is none or its peer has its share.
  void Add(dds_instance_handle_t writer, const WriterFacts& facts, const Seats& seats);

  std::array<Slot, kMaxWriters> slots_;
};

}  // namespace tandem
