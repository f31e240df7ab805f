#include "collab/dds/cyclone/writer_rate_limiter.h"

#include <algorithm>
#include <utility>

#include "engine/base/check.h"

namespace tandem {
namespace {

constexpr std::size_t kTableSize = 2 * WriterRateLimiter::kMaxKeys;
static_assert((kTableSize & (kTableSize - 1)) == 0);

std::size_t HashOf(std::size_t slot, std::uint64_t key) {
  const std::uint64_t mixed = (key ^ (std::uint64_t{slot} << 40U)) * 0x9E3779B97F4A7C15U;
  return static_cast<std::size_t>(mixed >> 32U) & (kTableSize - 1);
}

}  // namespace

WriterRateLimiter::WriterRateLimiter(const WriterLimits& limits)
    : limits_(limits),
      interval_ns_(1'000'000'000 / limits.per_second),
      slots_(kMaxWriters),
      table_(kTableSize),
      spare_(kTableSize) {
  TANDEM_CHECK(limits.per_second > 0 && limits.at_once > 0 && limits.keys > 0 && limits.of_one > 0);
}

std::optional<Drop> WriterRateLimiter::Refuses(std::uint64_t writer, std::uint64_t participant,
                                               std::uint64_t key, std::int64_t now_ns) noexcept {
  const std::optional<std::size_t> found = SlotOf(writer, participant);
  if (!found) return Drop::kManyWriters;
  Slot& slot = slots_[*found];
  if (now_ns < slot.ignored_to_ns) return Drop::kFlood;
  slot.room_from_ns = std::max(slot.room_from_ns, now_ns);
  if (slot.room_from_ns - now_ns > limits_.at_once * interval_ns_) {
    slot.ignored_to_ns = now_ns + kIgnoredNs;
    return Drop::kFlood;
  }
  slot.room_from_ns += interval_ns_;
  if (!HasKey(*found, key)) return Drop::kManyKeys;
  return std::nullopt;
}

std::optional<std::size_t> WriterRateLimiter::SlotOf(std::uint64_t writer,
                                                     std::uint64_t participant) noexcept {
  if (slots_[newest_].writer == writer) return newest_;
  std::size_t free = kMaxWriters;
  int of_one = 0;
  for (std::size_t i = 0; i < kMaxWriters; ++i) {
    if (slots_[i].writer == writer) return newest_ = i;
    if (slots_[i].writer == 0) {
      free = std::min(free, i);
    } else if (slots_[i].participant == participant) {
      ++of_one;
    }
  }
  if (free == kMaxWriters || of_one >= limits_.of_one) return std::nullopt;
  slots_[free] = Slot{};
  slots_[free].writer = writer;
  slots_[free].participant = participant;
  ++writers_;
  return newest_ = free;
}

std::size_t WriterRateLimiter::PlaceOf(std::size_t slot, std::uint64_t key) const noexcept {
  std::size_t place = HashOf(slot, key);
  while (table_[place].key != 0 && (table_[place].key != key || table_[place].slot != slot)) {
    place = (place + 1) & (kTableSize - 1);
  }
  return place;
}

bool WriterRateLimiter::HasKey(std::size_t slot, std::uint64_t key) noexcept {
  const std::size_t place = PlaceOf(slot, key);
  if (table_[place].key != 0) return true;
  if (slots_[slot].keys >= limits_.keys || keys_ >= kMaxKeys) return false;
  table_[place] = {.key = key, .slot = static_cast<std::uint32_t>(slot)};
  ++slots_[slot].keys;
  ++keys_;
  return true;
}

void WriterRateLimiter::Forget(std::uint64_t writer) noexcept {
  const auto found = std::ranges::find(slots_, writer, &Slot::writer);
  if (found == slots_.end()) return;
  const auto gone = static_cast<std::uint32_t>(found - slots_.begin());
  keys_ -= static_cast<std::size_t>(found->keys);
  *found = {};
  --writers_;
  // without the writer's entries, others may belong to earlier places, so the table is filled anew
  std::swap(table_, spare_);
  std::ranges::fill(table_, Key{});
  for (const Key& key : spare_) {
    if (key.key != 0 && key.slot != gone) table_[PlaceOf(key.slot, key.key)] = key;
  }
}

}  // namespace tandem
