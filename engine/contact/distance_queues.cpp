#include "engine/contact/distance_queues.h"

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

void DistanceQueues::Sleep(std::size_t address) noexcept {
  if (queue_of_[address] == kAsleep) return;
  Clear(address, queue_of_[address]);
  queue_of_[address] = kAsleep;
}

}  // namespace tandem
