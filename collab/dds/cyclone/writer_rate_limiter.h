#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "collab/session/drop_counts.h"

namespace tandem {

/// Limits on what the writers of one topic may send to a reader. An honest writer stays far below.
struct WriterLimits {
  int per_second = 0;  // samples from a writer
  int at_once = 0;     // further samples at once, after a pause of the network
  int keys = 0;        // instances of a writer
  int of_one = 0;      // writers of a participant
};

/// Decides whether samples pass to a reader, by the rate and the number of keys of their writers,
/// before anything of them is kept. It refuses a writer beyond its rate for kIgnoredNs. All memory
/// is taken at construction; kMaxWriters and kMaxKeys bound what a reader keeps. The class reads no
/// clock. Used by one thread at a time.
class WriterRateLimiter {
 public:
  static constexpr std::size_t kMaxWriters = 256;
  static constexpr std::size_t kMaxKeys = 8192;  // over all writers together
  static constexpr std::int64_t kIgnoredNs = 1'000'000'000;

  explicit WriterRateLimiter(const WriterLimits& limits);

  /// Returns why the sample is refused, or nothing if it passes. `writer`, `participant` and `key`
  /// are numbers other than 0 that identify them.
  std::optional<Drop> Refuses(std::uint64_t writer, std::uint64_t participant, std::uint64_t key,
                              std::int64_t now_ns) noexcept;
  /// Forgets a writer that has gone, and its keys.
  void Forget(std::uint64_t writer) noexcept;

  std::size_t writers() const noexcept { return writers_; }
  std::size_t keys() const noexcept { return keys_; }

 private:
  struct Slot {
    std::uint64_t writer = 0;  // 0: free
    std::uint64_t participant = 0;
    std::int64_t room_from_ns = 0;   // time at which all that was let through is paid off
    std::int64_t ignored_to_ns = 0;  // earlier samples are refused
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
  std::vector<Key> spare_;  // used by Forget()
  std::size_t newest_ = 0;  // slot of the last request
  std::size_t writers_ = 0;
  std::size_t keys_ = 0;
};

}  // namespace tandem
