#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tandem {

/// Shows what random access costs on this machine, whatever is done with the data. It reads single
/// 64-byte lines at random places, with as many reads under way at once as the processor allows.
class RandomLines {
 public:
  /// Draws `count` random lines of `bytes`, which must outlive this object.
  RandomLines(std::span<const std::byte> bytes, std::size_t count, std::uint64_t seed);
  std::size_t count() const noexcept { return lines_.size(); }
  /// Reads lines [first, last). The sum keeps the compiler from leaving the reads out.
  std::uint64_t Read(std::size_t first, std::size_t last) const noexcept;

 private:
  std::span<const std::byte> bytes_;
  std::vector<std::uint32_t> lines_;
};

}  // namespace tandem
