#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "collab/drop_counts.h"

namespace tandem {

/// What the writers of one topic may send to a reader. An honest one stays far below.
struct WriterLimits {
  int per_second = 0;  // samples of a writer
  int at_once = 0;     // as many more, after a stay of the network
  int keys = 0;        // instances of a writer
  int of_one = 0;      // writers of a participant
};

/// Lets the samples of a reader's writers through or not, by their rate and by the number of their
/// keys, before anything is kept of them. A writer beyond its rate is not heard for kIgnoredNs. All
/// memory is taken at construction; what is kept in a reader is bounded by kMaxWriters and kMaxKeys.
/// Times are handed in. Used by one thread at a time.
class WriterGate {
 public:
  static constexpr std::size_t kMaxWriters = 256;
  static constexpr std::size_t kMaxKeys = 8192;  // of all writers together
  static constexpr std::int64_t kIgnoredNs = 1'000'000'000;

  explicit WriterGate(const WriterLimits& limits);

  /// Why the sample is refused; nothing: it is let through. `writer`, `participant` and `key` are
  /// numbers that stand for them, not 0.
  std::optional<Drop> Refuses(std::uint64_t writer, std::uint64_t participant, std::uint64_t key,
                              std::int64_t now_ns) noexcept;
  /// The writer has gone, and its keys with it.
  void Forget(std::uint64_t writer) noexcept;

  std::size_t writers() const noexcept { return writers_; }
  std::size_t keys() const noexcept { return keys_; }

 private:
  struct Slot {
    std::uint64_t writer = 0;  // 0: free
    std::uint64_t participant = 0;
    std::int64_t room_from_ns = 0;   // when all that was let through is paid off
    std::int64_t ignored_to_ns = 0;  // samples before are refused
    int keys = 0;
  };
  struct Key {
    std::uint64_t key = 0;  // 0: free
    std::uint32_t slot = 0;
  };

  std::optional<std::size_t> SlotOf(std::uint64_t writer, std::uint64_t participant) noexcept;
  bool HasKey(std::size_t slot, std::uint64_t key) noexcept;
  std::size_t PlaceOf(std::size_t slot, std::uint64_t key) const noexcept;

  const WriterLimits limits_;
  const std::int64_t interval_ns_;
  std::vector<Slot> slots_;
  std::vector<Key> table_;  // open addressing, at most half full
  std::vector<Key> spare_;  // for Forget()
  std::size_t newest_ = 0;  // the slot that was asked for last
  std::size_t writers_ = 0;
  std::size_t keys_ = 0;
};

}  // namespace tandem
