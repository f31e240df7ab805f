#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "engine/base/check.h"

namespace tandem {

/// Hands values from one pushing thread to one popping thread: all of them, in order. Neither ever
/// waits. Nothing is allocated after construction, including copies of T: T must not own memory.
/// For the newest value only, use TripleBuffer.
template <typename T>
class SpscQueue {
  static_assert(std::is_copy_assignable_v<T> && std::is_default_constructible_v<T>);
  static_assert(!std::is_same_v<T, bool>);  // a vector of bits is shared between threads

 public:
  /// Holds up to `capacity` values, at least one.
  explicit SpscQueue(std::size_t capacity) : capacity_(capacity) {
    TANDEM_CHECK(capacity > 0);
    std::size_t size = 1;
    while (size < capacity) size *= 2;
    mask_ = size - 1;
    ring_.resize(size);
  }

  std::size_t capacity() const noexcept { return capacity_; }

  /// Pushes a value; returns false when the queue is full. Pushing thread only.
  bool TryPush(const T& value) noexcept {
    T* const room = Room();
    if (room == nullptr) return false;
    *room = value;
    Push();
    return true;
  }

  /// Returns the place of the next value, which the caller writes there and then Push()es; the
  /// place still has an older value. Null when the queue is full. Pushing thread only.
  T* Room() noexcept {
    const std::uint64_t pushed = pushed_.load(std::memory_order_relaxed);
    if (pushed - popped_seen_ >= capacity_) {
      popped_seen_ = popped_.load(std::memory_order_acquire);
      if (pushed - popped_seen_ >= capacity_) return nullptr;
    }
    return &ring_[pushed & mask_];
  }
  void Push() noexcept {
    pushed_.store(pushed_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  /// Pops a value; returns false, and leaves `value` alone, when the queue is empty. Popping thread
  /// only.
  bool TryPop(T& value) noexcept {
    const T* front = Front();
    if (front == nullptr) return false;
    value = *front;
    Drop();
    return true;
  }

  /// Returns the oldest value, to be looked at before it is due; null when the queue is empty.
  /// Popping thread only.
  const T* Front() noexcept {
    const std::uint64_t popped = popped_.load(std::memory_order_relaxed);
    if (popped == pushed_seen_) {
      pushed_seen_ = pushed_.load(std::memory_order_acquire);
      if (popped == pushed_seen_) return nullptr;
    }
    return &ring_[popped & mask_];
  }

  /// Removes the oldest value, which Front() has shown. Popping thread only.
  void Drop() noexcept {
    popped_.store(popped_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

 private:
  std::size_t capacity_;
  std::size_t mask_ = 0;
  std::vector<T> ring_;

  // Each thread's counter and its last reading of the other's, on its own cache line.
  alignas(64) std::atomic<std::uint64_t> pushed_{0};
  std::uint64_t popped_seen_ = 0;
  alignas(64) std::atomic<std::uint64_t> popped_{0};
  std::uint64_t pushed_seen_ = 0;
};

}  // namespace tandem
