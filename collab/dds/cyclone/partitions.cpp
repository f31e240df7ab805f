#include "collab/dds/cyclone/partitions.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <vector>

namespace tandem {
namespace {

constexpr std::string_view kPeerPrefix = "peer.";
constexpr std::string_view kViewPrefix = "view.";
constexpr std::string_view kScenePrefix = "scene.";
constexpr std::string_view kViewerPrefix = "viewer.";
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

std::string ScenePartition(PeerId peer) {
  return Partition(kScenePrefix, peer);
}
std::string ViewerPartition(PeerId peer) {
  return Partition(kViewerPrefix, peer);
}
std::string NamedPartition(const std::string& partition, const std::string& name) {
  std::string named = partition + ".";
  for (const char c : name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '.' || c == '_' || c == '-';
    named += plain ? c : '_';
  }
  return named;
}

PartitionOwner OwnerOfPartition(std::string_view partition) {
  for (const std::string_view prefix : {kPeerPrefix, kViewPrefix, kScenePrefix, kViewerPrefix}) {
    if (!partition.starts_with(prefix)) continue;
    const std::string_view rest = partition.substr(prefix.size());
    const std::string_view digits = rest.substr(0, kIdDigits);
    PartitionOwner owner;
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), owner.peer, 16);
    const bool whole = error == std::errc() && end == digits.data() + digits.size();
    if (!whole || digits.size() != kIdDigits) return {};
    if (rest.size() == kIdDigits) return owner;
    if (rest[kIdDigits] != '.' || rest.size() == kIdDigits + 1) return {};
    owner.name = rest.substr(kIdDigits + 1);
    return owner;
  }
  return {};
}

WriterFacts FactsOfWriter(dds_entity_t reader, dds_instance_handle_t writer) {
  dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader, writer);
  if (endpoint == nullptr) return {};
  WriterFacts facts;
  facts.participant = endpoint->participant_instance_handle;
  std::copy_n(endpoint->participant_key.v, facts.program.size(), facts.program.begin());
  std::uint32_t count = 0;
  char** partitions = nullptr;
  if (dds_qget_partition(endpoint->qos, &count, &partitions)) {
    if (count == 1) facts.owner = OwnerOfPartition(partitions[0]);
    for (std::uint32_t i = 0; i < count; ++i) dds_free(partitions[i]);
    dds_free(partitions);
  }
  dds_builtintopic_free_endpoint(endpoint);
  return facts;
}

std::size_t WriterOwners::Refresh(dds_entity_t reader, const Seats& seats) {
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
  for (const dds_instance_handle_t writer : writers) {
    if (!Has(writer)) Add(writer, FactsOfWriter(reader, writer), seats);
  }
  for (Slot& slot : slots_) {
    const auto seat = seats.find(slot.facts.owner.peer);
    const bool taken = seat != seats.end() && seat->second != slot.facts.participant;
    const PeerId owner = taken ? 0 : slot.facts.owner.peer;
    slot.owner.store(owner != 0 ? owner : kNobody);
  }
  const auto known = std::ranges::count_if(slots_, [](const Slot& slot) {
    return slot.writer.load() != 0;
  });
  return writers.size() - static_cast<std::size_t>(known);
}

bool WriterOwners::Has(dds_instance_handle_t writer) const noexcept {
  return std::ranges::any_of(slots_, [writer](const Slot& slot) {
    return slot.writer.load() == writer;
  });
}

void WriterOwners::Add(dds_instance_handle_t writer, const WriterFacts& facts, const Seats& seats) {
  const auto is_seated = [&seats](const WriterFacts& of) {
    const auto seat = seats.find(of.owner.peer);
    return seat != seats.end() && seat->second == of.participant;
  };
  const bool seated = is_seated(facts);
  Slot* place = nullptr;
  std::size_t of_one = 0;
  for (Slot& slot : slots_) {
    if (slot.writer.load() == 0) {
      if (place == nullptr || place->writer.load() != 0) place = &slot;
      continue;
    }
    const bool of_program = slot.facts.participant == facts.participant;
    if (slot.facts.owner.peer == facts.owner.peer && (of_program || !seated)) ++of_one;
    // a writer that has a seat takes the place of one that has none
    if (place == nullptr && seated && !is_seated(slot.facts)) place = &slot;
  }
  if (place == nullptr || of_one >= kMaxOfOne) return;
  place->writer.store(0);
  place->facts = facts;
  place->owner.store(0);  // not known until the seats have been looked at
  place->writer.store(writer);
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
