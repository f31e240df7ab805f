#include "app/bench/measure/memory_limit.h"

#include <cstring>
#include <random>

namespace tandem {

namespace {
constexpr std::size_t kLine = 64;
constexpr std::size_t kAhead = 48;  // lines that are fetched before they are read
}  // namespace

RandomLines::RandomLines(std::span<const std::byte> bytes, std::size_t count, std::uint64_t seed)
    : bytes_(bytes), lines_(count) {
  std::mt19937_64 random(seed);
  const std::uint64_t lines = bytes.size() / kLine;
  for (std::uint32_t& line : lines_) line = static_cast<std::uint32_t>(random() % lines);
}

std::uint64_t RandomLines::Read(std::size_t first, std::size_t last) const noexcept {
  std::uint64_t sum = 0;
  for (std::size_t i = first; i < last; ++i) {
    if (i + kAhead < last) __builtin_prefetch(&bytes_[kLine * lines_[i + kAhead]]);
    std::uint64_t word = 0;
    std::memcpy(&word, &bytes_[kLine * lines_[i]], sizeof word);
    sum += word;
  }
  return sum;
}

}  // namespace tandem
