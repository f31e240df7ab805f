#include "collab/session/drop_counts.h"

#include <numeric>

namespace tandem {

const char* NameOf(Drop reason) noexcept {
  switch (reason) {
    case Drop::kNotFinite:
      return "not_finite";
    case Drop::kHuge:
      return "huge";
    case Drop::kNotUnit:
      return "not_unit";
    case Drop::kBadCount:
      return "bad_count";
    case Drop::kWrongOwner:
      return "wrong_owner";
    case Drop::kNoOwner:
      return "no_owner";
    case Drop::kReplayed:
      return "replayed";
    case Drop::kWrongEpoch:
      return "wrong_epoch";
    case Drop::kBadEcho:
      return "bad_echo";
    case Drop::kRingFull:
      return "ring_full";
    case Drop::kFlood:
      return "flood";
    case Drop::kManyKeys:
      return "many_keys";
    case Drop::kManyWriters:
      return "many_writers";
    case Drop::kImpostor:
      return "impostor";
    case Drop::kTwin:
      return "twin";
    case Drop::kRevoked:
      return "revoked";
    case Drop::kStranger:
      return "stranger";
    case Drop::kNotOwner:
      return "not_owner";
    case Drop::kSeized:
      return "seized";
    case Drop::kEpochLeap:
      return "epoch_leap";
    case Drop::kAbsurdScene:
      return "absurd_scene";
    case Drop::kCount:
      break;
  }
  return "";
}

const char* ReasonText(Drop reason) noexcept {
  switch (reason) {
    case Drop::kFlood:
      return "sends far too many messages and is ignored for a second at a time";
    case Drop::kManyKeys:
      return "names more bodies than a scene can have";
    case Drop::kManyWriters:
      return "sends through more writers than a program has";
    case Drop::kImpostor:
      return "sends in another's name, or another sends in its name";
    case Drop::kTwin:
      return "is here twice: another program uses its keys, and the later one is ignored";
    case Drop::kRevoked:
      return "takes part with keys that have been revoked";
    case Drop::kStranger:
      return "sends commands without taking part";
    case Drop::kNotOwner:
      return "gives away or refuses bodies that it is not the authority of";
    case Drop::kSeized:
      return "claims bodies that others have and have not given away";
    case Drop::kEpochLeap:
      return "claims bodies with a greater epoch than grabs can lead to";
    case Drop::kAbsurdScene:
      return "offers the session an invalid scene";
    default:
      return nullptr;
  }
}

std::uint64_t TellFrom(Drop reason) noexcept {
  switch (reason) {
    case Drop::kFlood:
    case Drop::kManyKeys:
    case Drop::kManyWriters:
      return 20;  // fewer are an accident, as a program starts or ends
    case Drop::kStranger:
    case Drop::kNotOwner:
      return 3;
    default:
      return 1;
  }
}

std::uint64_t SumOf(const DropCounts& counts) noexcept {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

DropTable::Row& DropTable::RowOf(PeerId peer) noexcept {
  if (peer == 0) return nobody_;
  for (Row& row : rows_) {
    PeerId owner = row.peer.load(std::memory_order_relaxed);
    // the first of the two threads takes a free row
    if (owner == 0 && row.peer.compare_exchange_strong(owner, peer)) return row;
    if (owner == peer) return row;
  }
  return nobody_;
}

void DropTable::Count(PeerId peer, Drop reason) noexcept {
  RowOf(peer).counts[static_cast<std::size_t>(reason)].fetch_add(1, std::memory_order_relaxed);
}

DropCounts DropTable::Read(const Row& row) noexcept {
  DropCounts counts{};
  for (std::size_t i = 0; i < counts.size(); ++i) {
    counts[i] = row.counts[i].load(std::memory_order_relaxed);
  }
  return counts;
}

DropCounts DropTable::CountsOf(PeerId peer) const noexcept {
  if (peer == 0) return Read(nobody_);
  for (const Row& row : rows_) {
    if (row.peer.load(std::memory_order_relaxed) == peer) return Read(row);
  }
  return {};
}

std::vector<std::pair<PeerId, DropCounts>> DropTable::Rows() const {
  std::vector<std::pair<PeerId, DropCounts>> rows;
  const auto add = [&rows](const Row& row) {
    const DropCounts counts = Read(row);
    if (SumOf(counts) > 0) rows.emplace_back(row.peer.load(std::memory_order_relaxed), counts);
  };
  add(nobody_);
  for (const Row& row : rows_) add(row);
  return rows;
}

DropCounts DropTable::Total() const noexcept {
  DropCounts total = Read(nobody_);
  for (const Row& row : rows_) {
    const DropCounts counts = Read(row);
    for (std::size_t i = 0; i < total.size(); ++i) total[i] += counts[i];
  }
  return total;
}

}  // namespace tandem
