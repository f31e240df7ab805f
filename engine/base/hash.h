#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace tandem {

/// A running 64-bit content hash: the same bytes in the same order give the same value on every
/// machine. Not for security: it finds accidents, not forgeries.
class Hash64 {
 public:
  void AddBytes(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) state_ = (state_ ^ bytes[i]) * kPrime;
  }
  template <typename T>
  void Add(const T& value) {
    static_assert(std::is_trivially_copyable_v<T> && std::has_unique_object_representations_v<T>);
    AddBytes(&value, sizeof value);
  }
  void Add(double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    Add(bits);
  }
  /// Returns the hash, mixed, so that values that differ in one bit differ in about half of their
  /// bits.
  std::uint64_t value() const {
    std::uint64_t x = state_;
    x ^= x >> 33U;
    x *= 0xff51afd7ed558ccdULL;
    x ^= x >> 33U;
    x *= 0xc4ceb9fe1a85ec53ULL;
    return x ^ (x >> 33U);
  }

 private:
  static constexpr std::uint64_t kPrime = 0x100000001b3ULL;  // FNV-1a
  std::uint64_t state_ = 0xcbf29ce484222325ULL;
};

}  // namespace tandem
