#pragma once

#include <array>
#include <atomic>
#include <map>
#include <string>
#include <string_view>

#include "collab/dds/cyclone/dds_api.h"
#include "collab/dds/cyclone/program_id.h"
#include "collab/session/messages.h"

namespace tandem {

inline constexpr const char* kEveryPeer = "peer.*";
inline constexpr const char* kEveryView = "view.*";
inline constexpr const char* kEveryScene = "scene.*";
inline constexpr const char* kEveryViewer = "viewer.*";

std::string PeerPartition(PeerId peer);    // for state/1, link/2, event, peer_info
std::string ViewPartition(PeerId peer);    // for view/1
std::string ScenePartition(PeerId peer);   // for scene
std::string ViewerPartition(PeerId peer);  // for viewer_info

/// Returns the partition for peer_info and viewer_info in a secured session. The name is part of
/// it, so permissions bind the name too. Characters that no member's name has become '_'.
std::string NamedPartition(const std::string& partition, const std::string& name);

/// The peer and name that a partition gives to its publisher.
struct PartitionOwner {
  PeerId peer = 0;   // 0: no peer's partition
  std::string name;  // empty: the partition has no name

  friend bool operator==(const PartitionOwner&, const PartitionOwner&) = default;
};
PartitionOwner OwnerOfPartition(std::string_view partition);

/// The origin of a writer as far as DDS knows it: its participant, and the owner of the only
/// partition in which it publishes to `reader`. DDS permissions protect no more of a peer's
/// identity. So a sample counts as its peer's only if it comes through that peer's partition.
struct WriterFacts {
  PartitionOwner owner;                   // nobody: unknown, gone, or in several partitions
  dds_instance_handle_t participant = 0;  // 0: unknown or gone
  ProgramId program{};                    // the same one, as packets name it
};
WriterFacts FactsOfWriter(dds_entity_t reader, dds_instance_handle_t writer);

/// Which participant speaks for each peer that is here: the one that was heard first as that peer,
/// until the peer is gone. Samples of other participants in that peer's partitions do not count as
/// the peer's. In a secured session permissions ensure this; in a plain one nothing else does. Used
/// by the control thread.
using Seats = std::map<PeerId, dds_instance_handle_t>;

/// Owners of the writers that match a reader. The control thread writes them, the receive thread
/// reads them. When there are more writers than places, the first ones keep theirs, so a flood of
/// newcomers mutes no known peer.
class WriterOwners {
 public:
  /// Owner of a writer in several partitions, or in no peer's partition.
  static constexpr PeerId kNobody = ~PeerId{0};

  /// The table has room for a crashed peer's writers, which stay until its lease ends, beside those
  /// of its successor.
  static constexpr std::size_t kMaxWriters = 16 * kMaxPeers;
  static constexpr std::size_t kMaxOfOne = 4;  // writers in one peer's partition

  /// Returns how many writers found no place; they are not heard. Writers in a partition whose peer
  /// has another participant's seat belong to kNobody.
  std::size_t Refresh(dds_entity_t reader, const Seats& seats = {});
  PeerId Find(dds_instance_handle_t writer) const noexcept;  // 0: not known yet

 private:
  struct Slot {
    std::atomic<dds_instance_handle_t> writer =
        0;  // handles are never used for two writers in a process's life
    std::atomic<PeerId> owner = 0;
    WriterFacts facts;  // used by the control thread
  };

  bool Has(dds_instance_handle_t writer) const noexcept;
  /// Gives the writer a place, unless there is none or its peer has its share.
  void Add(dds_instance_handle_t writer, const WriterFacts& facts, const Seats& seats);

  std::array<Slot, kMaxWriters> slots_;
};

}  // namespace tandem
