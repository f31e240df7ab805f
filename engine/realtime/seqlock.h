#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace tandem {

/// The newest value of one writer, for any number of readers, in memory that processes may share.
/// No thread waits for another: a reader that finds the writer at work tries again a few times and
/// then goes without. So a writer that dies or is stopped within Write() leaves readers without
/// news, never without time. Between threads of one process TripleBuffer needs one copy only.
template <typename T>
class Seqlock {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  static constexpr int kTries = 16;

  void Write(const T& value) noexcept {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), &value, sizeof value);
    const std::uint64_t turn = turn_.load(std::memory_order_relaxed);
    turn_.store(turn + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    for (std::size_t i = 0; i < kWords; ++i) {
      words_[i].store(words[i], std::memory_order_relaxed);
    }
    turn_.store(turn + 2, std::memory_order_release);
  }

  /// Returns false, and leaves `value` alone, if nothing was ever written or the writer is at work.
  bool Read(T& value) const noexcept {
    for (int i = 0; i < kTries; ++i) {
      const std::uint64_t before = turn_.load(std::memory_order_acquire);
      if (before == 0) return false;
      if (before % 2 != 0) continue;
      std::array<std::uint64_t, kWords> words;
      for (std::size_t w = 0; w < kWords; ++w) words[w] = words_[w].load(std::memory_order_relaxed);
      std::atomic_thread_fence(std::memory_order_acquire);
      if (turn_.load(std::memory_order_relaxed) != before) continue;
      std::memcpy(static_cast<void*>(&value), words.data(), sizeof value);
      return true;
    }
    return false;
  }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;

  alignas(64) std::atomic<std::uint64_t> turn_{0};  // odd while the writer is at work
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace tandem
