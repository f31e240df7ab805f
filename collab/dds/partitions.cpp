#include "collab/dds/partitions.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <vector>

namespace tandem {
namespace {

constexpr std::string_view kPeerPrefix = "peer.";
constexpr std::string_view kViewPrefix = "view.";
constexpr std::size_t kIdDigits = 16;

std::string Partition(std::string_view prefix, PeerId peer) {
  std::array<char, kIdDigits + 1> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(peer));
  return std::string(prefix) + digits.data();
}

}  // namespace

std::string PeerPartition(PeerId peer) {
  return Partition(kPeerPrefix, peer);
}
std::string ViewPartition(PeerId peer) {
  return Partition(kViewPrefix, peer);
}

PeerId OwnerOfPartition(std::string_view partition) {
  if (!partition.starts_with(kPeerPrefix) && !partition.starts_with(kViewPrefix)) return 0;
  const std::string_view digits = partition.substr(kPeerPrefix.size());
  PeerId peer = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), peer, 16);
  const bool whole = error == std::errc() && end == digits.data() + digits.size();
  return whole && digits.size() == kIdDigits ? peer : 0;
}

PeerId OwnerOfWriter(dds_entity_t reader, dds_instance_handle_t writer) {
  dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader, writer);
  if (endpoint == nullptr) return 0;
  PeerId owner = 0;
  std::uint32_t count = 0;
  char** partitions = nullptr;
  if (dds_qget_partition(endpoint->qos, &count, &partitions)) {
    if (count == 1) owner = OwnerOfPartition(partitions[0]);
    for (std::uint32_t i = 0; i < count; ++i) dds_free(partitions[i]);
    dds_free(partitions);
  }
  dds_builtintopic_free_endpoint(endpoint);
  return owner;
}

std::size_t WriterOwners::Refresh(dds_entity_t reader) {
  std::vector<dds_instance_handle_t> writers(kMaxWriters);
  dds_return_t found = 0;
  for (;;) {
    found = dds_get_matched_publications(reader, writers.data(), writers.size());
    if (found < 0) return 0;
    if (static_cast<std::size_t>(found) <= writers.size()) break;
    writers.resize(2 * static_cast<std::size_t>(found));
  }
  writers.resize(static_cast<std::size_t>(found));
  std::ranges::sort(writers);

  for (Slot& slot : slots_) {
    if (!std::ranges::binary_search(writers, slot.writer.load())) slot.writer.store(0);
  }
  std::size_t without_place = 0;
  for (const dds_instance_handle_t writer : writers) {
    if (Find(writer) != 0) continue;
    const PeerId owner = OwnerOfWriter(reader, writer);
    if (!Add(writer, owner != 0 ? owner : kNobody)) ++without_place;
  }
  return without_place;
}

bool WriterOwners::Add(dds_instance_handle_t writer, PeerId owner) {
  for (Slot& slot : slots_) {
    if (slot.writer.load() != 0) continue;
    slot.owner.store(owner);
    slot.writer.store(writer);
    return true;
  }
  return false;
}

PeerId WriterOwners::Find(dds_instance_handle_t writer) const noexcept {
  for (const Slot& slot : slots_) {
    if (slot.writer.load(std::memory_order_acquire) != writer) continue;
    const PeerId owner = slot.owner.load(std::memory_order_acquire);
    // the slot may have been given to another writer in between
    return slot.writer.load(std::memory_order_acquire) == writer ? owner : 0;
  }
  return 0;
}

}  // namespace tandem
