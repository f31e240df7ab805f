#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "collab/messages.h"
#include "engine/base/check.h"

namespace tandem {

/// Values ordered by when they are due, those of the same time by when they were pushed: what one
/// sender's delay holds back does not stand in the way of another's. A heap of places; all memory
/// is taken at construction. Used by one thread.
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

  /// Makes room for as many, if there is less. Allocates: not for a haptic thread.
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

  /// False, and nothing is taken, when the queue is full.
  bool Push(std::int64_t due_ns, const T& value) noexcept {
    if (free_.empty()) return false;
    const std::uint32_t place = free_.back();
    free_.pop_back();
    CopyUsed(values_[place], value);
    heap_.push_back({due_ns, pushed_++, place});
    std::push_heap(heap_.begin(), heap_.end(), IsLater);
    return true;
  }

  /// The value that is due first, if that is not after `now_ns`; else null.
  const T* Due(std::int64_t now_ns) const noexcept {
    if (heap_.empty() || heap_.front().due_ns > now_ns) return nullptr;
    return &values_[heap_.front().place];
  }

  /// Gives up the value that is due first; there is one.
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
