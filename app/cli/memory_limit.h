#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tandem {

/// What random access costs on this machine, whatever is done with it: reads of one 64-byte line
/// each at random places of some bytes, as many under way at once as the processor will have.
class RandomLines {
 public:
  /// `count` random lines of `bytes`, which must outlive this.
  RandomLines(std::span<const std::byte> bytes, std::size_t count, std::uint64_t seed);
  std::size_t count() const noexcept { return lines_.size(); }
  /// Reads lines [first, last); the sum keeps the reads from being left out.
  std::uint64_t Read(std::size_t first, std::size_t last) const noexcept;

 private:
  std::span<const std::byte> bytes_;
  std::vector<std::uint32_t> lines_;
};

}  // namespace tandem
