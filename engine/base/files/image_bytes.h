#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "engine/base/result.h"

namespace tandem {

/// Memory in whole pages, for which huge pages are asked from 2 MiB on; or the bytes of a file,
/// mapped read-only.
class ImageBytes {
 public:
  ImageBytes() = default;
  /// Allocates zeroed memory. Check-fails when the machine has too little.
  explicit ImageBytes(std::size_t size);
  ~ImageBytes();
  ImageBytes(ImageBytes&& other) noexcept;
  ImageBytes& operator=(ImageBytes&& other) noexcept;
  ImageBytes(const ImageBytes&) = delete;
  ImageBytes& operator=(const ImageBytes&) = delete;

  /// Maps a file's bytes, read-only, or returns the error. A program that writes to the file while
  /// it is mapped changes the bytes, and a program that cuts it short ends the programs that read
  /// them. So files are replaced, never written to (WholeFile), and lie where nobody else may
  /// write.
  static Result<ImageBytes> Map(const std::filesystem::path& file);

  /// Gives back the bytes beyond `size`.
  void Shrink(std::size_t size);

  std::byte* data() noexcept { return data_; }
  const std::byte* data() const noexcept { return data_; }
  std::size_t size() const noexcept { return size_; }

 private:
  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t mapped_ = 0;
};

/// A part of an image, which it keeps alive.
struct ImageBlock {
  std::shared_ptr<const ImageBytes> image;
  std::span<const std::byte> bytes;
};

/// Places the arrays of a block one behind the other, each on a cache line.
class ArrayLayout {
 public:
  static constexpr std::uint64_t kLine = 64;
  /// No block is larger, so that sums of fewer than 2^16 of them do not wrap round.
  static constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 48U;

  explicit ArrayLayout(std::uint64_t header_bytes) : end_(header_bytes) {}

  /// Returns the place of the next array, in bytes from the block's start.
  std::uint64_t Add(std::uint64_t count, std::uint64_t element_bytes) {
    const std::uint64_t place = (end_ + kLine - 1) / kLine * kLine;
    const bool fits = place <= kMostBytes && count <= (kMostBytes - place) / element_bytes;
    end_ = fits ? place + count * element_bytes : kMostBytes + 1;
    return place;
  }
  /// Returns the bytes of the whole block. More than kMostBytes means that it is too large.
  std::uint64_t bytes() const noexcept { return end_; }

 private:
  std::uint64_t end_;
};

/// Returns an array of a block. It must lie within.
template <typename T>
std::span<const T> ArrayIn(std::span<const std::byte> block, std::uint64_t place,
                           std::uint64_t count) {
  return {reinterpret_cast<const T*>(block.data() + place), count};
}

}  // namespace tandem
