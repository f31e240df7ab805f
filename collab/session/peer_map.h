#pragma once

#include <array>
#include <cstddef>
#include <iterator>
#include <type_traits>

#include "collab/session/messages.h"

namespace tandem {

/// Keeps one value for each of at most N peers, in slots that never move; nothing allocates.
///
/// `T` has a field `PeerId peer`, the key, which the map alone writes; 0 marks a free slot. A new
/// peer gets the first free slot, with a value as constructed. Iteration visits the used slots in
/// order; the value that it has reached may be erased meanwhile.
template <typename T, std::size_t N>
class PeerMap {
  template <typename Value>
  class Iterator;

 public:
  using iterator = Iterator<T>;
  using const_iterator = Iterator<const T>;

  /// Returns the peer's value; null if it has none.
  T* Find(PeerId peer) noexcept { return FindIn(slots_, peer); }
  const T* Find(PeerId peer) const noexcept { return FindIn(slots_, peer); }

  /// Returns the peer's value, a new one if it has none yet; null if all slots are in use by
  /// others.
  T* FindOrInsert(PeerId peer) noexcept {
    if (T* const found = Find(peer)) return found;
    if (peer == 0) return nullptr;
    for (T& slot : slots_) {
      if (slot.peer != 0) continue;
      slot.peer = peer;
      return &slot;
    }
    return nullptr;
  }

  /// Frees the peer's slot, if it has one.
  void Erase(PeerId peer) noexcept {
    if (T* const found = Find(peer)) *found = T{};
  }
  void Clear() noexcept { slots_ = {}; }

  static constexpr std::size_t capacity() noexcept { return N; }
  /// Returns the value in a slot (0 to N - 1); null if the slot is free.
  T* InSlot(std::size_t slot) noexcept { return slots_[slot].peer == 0 ? nullptr : &slots_[slot]; }
  const T* InSlot(std::size_t slot) const noexcept {
    return slots_[slot].peer == 0 ? nullptr : &slots_[slot];
  }
  /// Returns the slot of a value of this map.
  std::size_t SlotOf(const T& value) const noexcept {
    return static_cast<std::size_t>(&value - slots_.data());
  }

  iterator begin() noexcept { return {slots_.data(), slots_.data() + N}; }
  iterator end() noexcept { return {slots_.data() + N, slots_.data() + N}; }
  const_iterator begin() const noexcept { return {slots_.data(), slots_.data() + N}; }
  const_iterator end() const noexcept { return {slots_.data() + N, slots_.data() + N}; }

 private:
  template <typename Slots>
  static auto FindIn(Slots& slots, PeerId peer) noexcept -> decltype(slots.data()) {
    if (peer == 0) return nullptr;
    for (auto& slot : slots) {
      if (slot.peer == peer) return &slot;
    }
    return nullptr;
  }

  std::array<T, N> slots_{};
};

/// Visits the used slots of a map in order.
template <typename T, std::size_t N>
template <typename Value>
class PeerMap<T, N>::Iterator {
 public:
  using iterator_category = std::forward_iterator_tag;
  using value_type = std::remove_const_t<Value>;
  using difference_type = std::ptrdiff_t;
  using pointer = Value*;
  using reference = Value&;

  Iterator() = default;
  Iterator(Value* at, Value* end) noexcept : at_(at), end_(end) { SkipFree(); }

  Value& operator*() const noexcept { return *at_; }
  Value* operator->() const noexcept { return at_; }
  Iterator& operator++() noexcept {
    ++at_;
    SkipFree();
    return *this;
  }
  Iterator operator++(int) noexcept {
    const Iterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const Iterator&) const = default;

 private:
  void SkipFree() noexcept {
    while (at_ != end_ && at_->peer == 0) ++at_;
  }

  Value* at_ = nullptr;
  Value* end_ = nullptr;
};

/// The key alone, where nothing is kept of a peer but that it is there.
struct PeerKey {
  PeerId peer = 0;
};

/// A set of at most N peers.
template <std::size_t N>
using PeerSet = PeerMap<PeerKey, N>;

}  // namespace tandem
