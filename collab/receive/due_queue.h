#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "collab/session/messages.h"
#include "engine/base/check.h"

namespace tandem {

/// A queue of values ordered by due time, and by push order for equal times, so that one sender's
/// delay does not hold back another's values. A heap of indices; the constructor takes all memory.
/// Used by one thread.
template <typename T>
class DueQueue {
 public:
  explicit DueQueue(std::size_t capacity) : values_(capacity) {
    TANDEM_CHECK(capacity > 0 && capacity <= UINT32_MAX);
    heap_.reserve(capacity);
    free_.reserve(capacity);
    for (std::size_t place = capacity; place > 0; --place) {
      free_.push_back(static_cast<std::uint32_t>(place - 1));
    }
  }

  /// Makes room for at least `capacity` values. Allocates: not for a haptic thread.
  void Reserve(std::size_t capacity) {
    TANDEM_CHECK(capacity <= UINT32_MAX);
    for (std::size_t place = values_.size(); place < capacity; ++place) {
      free_.push_back(static_cast<std::uint32_t>(place));
    }
    values_.resize(std::max(capacity, values_.size()));
    heap_.reserve(values_.size());
  }

  std::size_t size() const noexcept { return heap_.size(); }
  std::size_t capacity() const noexcept { return values_.size(); }

  /// Returns false, and takes nothing, when the queue is full.
  bool Push(std::int64_t due_ns, const T& value) noexcept {
    if (free_.empty()) return false;
    const std::uint32_t place = free_.back();
    free_.pop_back();
    CopyUsed(values_[place], value);
    heap_.push_back({due_ns, pushed_++, place});
    std::push_heap(heap_.begin(), heap_.end(), IsLater);
    return true;
  }

  /// Returns the value with the earliest due time if that is not after `now_ns`; otherwise null.
  const T* Due(std::int64_t now_ns) const noexcept {
    if (heap_.empty() || heap_.front().due_ns > now_ns) return nullptr;
    return &values_[heap_.front().place];
  }

  /// Removes the value with the earliest due time; the queue must not be empty.
  void Drop() noexcept {
    std::pop_heap(heap_.begin(), heap_.end(), IsLater);
    free_.push_back(heap_.back().place);
    heap_.pop_back();
  }

 private:
  struct Node {
    std::int64_t due_ns;
    std::uint64_t number;
    std::uint32_t place;
  };

  static bool IsLater(const Node& a, const Node& b) noexcept {
    return a.due_ns != b.due_ns ? a.due_ns > b.due_ns : a.number > b.number;
  }

  std::vector<T> values_;
  std::vector<Node> heap_;
  std::vector<std::uint32_t> free_;
  std::uint64_t pushed_ = 0;
};

}  // namespace tandem
