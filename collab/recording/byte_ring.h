#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "engine/base/check.h"

namespace tandem {

/// Passes blocks of bytes from one thread to one other. A block is composed piece by piece. It
/// becomes visible whole, or not at all when there is no room. Neither side waits; nothing is
/// allocated after construction.
class ByteRing {
 public:
  /// `size`: a power of two.
  explicit ByteRing(std::size_t size) : bytes_(size) {
    TANDEM_CHECK(size > 0 && (size & (size - 1)) == 0);
  }

  /// For the writing thread: begin a block, add to it, and show it with its length (32 bits) in
  /// front. Commit() returns false when the block did not fit; then it is dropped whole.
  void Open() noexcept {
    const std::uint32_t length = 0;
    Put(&length, sizeof length);
  }
  void Put(const void* data, std::size_t size) noexcept {
    full_ = full_ || put_ + size - taken_.load(std::memory_order_acquire) > bytes_.size();
    if (full_) return;
    Write(put_, data, size);
    put_ += size;
  }
  bool Commit() noexcept {
    const std::uint64_t begin = committed_.load(std::memory_order_relaxed);
    if (!full_) {
      const auto length = static_cast<std::uint32_t>(put_ - begin - sizeof(std::uint32_t));
      Write(begin, &length, sizeof length);
      committed_.store(put_, std::memory_order_release);
      return true;
    }
    Abandon();
    return false;
  }
  /// Drops the block in progress.
  void Abandon() noexcept {
    put_ = committed_.load(std::memory_order_relaxed);
    full_ = false;
  }

  /// For the reading thread: moves all visible blocks to the end of `out`.
  void TakeAll(std::vector<std::byte>& out) {
    const std::uint64_t end = committed_.load(std::memory_order_acquire);
    std::uint64_t from = taken_.load(std::memory_order_relaxed);
    while (from < end) {
      const std::size_t at = from & (bytes_.size() - 1);
      const std::size_t size = std::min<std::size_t>(end - from, bytes_.size() - at);
      out.insert(out.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at),
                 bytes_.begin() + static_cast<std::ptrdiff_t>(at + size));
      from += size;
    }
    taken_.store(end, std::memory_order_release);
  }

 private:
  void Write(std::uint64_t place, const void* data, std::size_t size) noexcept {
    const std::size_t at = place & (bytes_.size() - 1);
    const std::size_t first = std::min(size, bytes_.size() - at);
    std::memcpy(&bytes_[at], data, first);
    std::memcpy(bytes_.data(), static_cast<const std::byte*>(data) + first, size - first);
  }

  std::vector<std::byte> bytes_;
  std::uint64_t put_ = 0;
  bool full_ = false;
  alignas(64) std::atomic<std::uint64_t> committed_{0};
  alignas(64) std::atomic<std::uint64_t> taken_{0};
};

}  // namespace tandem
