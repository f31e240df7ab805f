#include "collab/drop_counts.h"

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
    case Drop::kCount:
      break;
  }
  return "";
}

std::uint64_t SumOf(const DropCounts& counts) noexcept {
  return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
}

DropTable::Row& DropTable::RowOf(PeerId peer) noexcept {
  if (peer == 0) return nobody_;
  for (Row& row : rows_) {
    PeerId owner = row.peer.load(std::memory_order_relaxed);
    // a free row is taken by whoever of the two threads comes first
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

DropCounts DropTable::Of(PeerId peer) const noexcept {
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
