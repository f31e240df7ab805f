#include "engine/contact/schedule/distance_queues.h"

#include <numeric>

namespace tandem {

DistanceQueues::DistanceQueues(std::size_t addresses)
    : words_((addresses + 63) / 64),
      upper_words_((words_ + 63) / 64),
      leaves_(kQueues * words_, 0),
      uppers_(kQueues * upper_words_, 0),
      queue_of_(addresses, kAsleep) {}

std::size_t DistanceQueues::awake() const noexcept {
  return std::accumulate(counts_.begin(), counts_.end(), std::size_t{0});
}

void DistanceQueues::Clear(std::size_t address, int queue) noexcept {
  const std::size_t word = address >> 6;
  std::uint64_t& leaf = Leaf(queue, word);
  leaf &= ~(std::uint64_t{1} << (address & 63));
  if (leaf == 0) {
    uppers_[At(queue) * upper_words_ + (word >> 6)] &= ~(std::uint64_t{1} << (word & 63));
  }
  --counts_[At(queue)];
}

void DistanceQueues::Put(std::size_t address, int queue) noexcept {
  const int before = queue_of_[address];
  if (before == queue) return;
  if (before != kAsleep) Clear(address, before);
  const std::size_t word = address >> 6;
  Leaf(queue, word) |= std::uint64_t{1} << (address & 63);
  uppers_[At(queue) * upper_words_ + (word >> 6)] |= std::uint64_t{1} << (word & 63);
  ++counts_[At(queue)];
  queue_of_[address] = static_cast<std::uint8_t>(queue);
}

void DistanceQueues::PutBeside(std::size_t address, int queue, Moves& moves) noexcept {
  const int before = queue_of_[address];
  if (before == queue) return;
  const std::size_t word = address >> 6;
  const std::uint64_t bit = std::uint64_t{1} << (address & 63);
  // the threads that share the work wait for its end
  constexpr auto kRelaxed = std::memory_order_relaxed;
  if (before != kAsleep) {
    // the upper bit stays: another thread may be about to put an address into the same word
    std::atomic_ref(Leaf(before, word)).fetch_and(~bit, kRelaxed);
    --moves[At(before)];
  }
  std::atomic_ref(Leaf(queue, word)).fetch_or(bit, kRelaxed);
  const std::uint64_t upper_bit = std::uint64_t{1} << (word & 63);
  const std::atomic_ref upper(uppers_[At(queue) * upper_words_ + (word >> 6)]);
  if ((upper.load(kRelaxed) & upper_bit) == 0) upper.fetch_or(upper_bit, kRelaxed);
  ++moves[At(queue)];
  queue_of_[address] = static_cast<std::uint8_t>(queue);
}

void DistanceQueues::Add(const Moves& moves) noexcept {
  for (std::size_t q = 0; q < counts_.size(); ++q) {
    counts_[q] = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(counts_[q]) + moves[q]);
  }
}

void DistanceQueues::Sleep(std::size_t address) noexcept {
  if (queue_of_[address] == kAsleep) return;
  Clear(address, queue_of_[address]);
  queue_of_[address] = kAsleep;
}

}  // namespace tandem
