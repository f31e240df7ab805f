#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace tandem {

/// Writes values one behind the other, with their bytes as in memory. For files that the same
/// program reads on the same machine.
class ByteWriter {
 public:
  template <typename T>
  void Add(const T& value) {
    AddBytes(&value, sizeof value);
  }
  /// Adds a string or a vector of values without pointers: their number, then the values.
  template <typename Array>
  void AddArray(const Array& values) {
    Add(static_cast<std::uint64_t>(values.size()));
    AddBytes(values.data(), values.size() * sizeof values[0]);
  }
  std::span<const std::byte> bytes() const noexcept { return bytes_; }

 private:
  void AddBytes(const void* from, std::size_t count) {
    const auto* begin = static_cast<const std::byte*>(from);
    bytes_.insert(bytes_.end(), begin, begin + count);
  }

  std::vector<std::byte> bytes_;
};

/// Reads them again. A missing value stays as it was, and good() is false from then on.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <typename T>
  void Read(T& value) {
    ReadBytes(&value, sizeof value);
  }
  template <typename Array>
  void ReadArray(Array& values) {
    std::uint64_t count = 0;
    Read(count);
    if (count > rest_.size() / sizeof values[0]) good_ = false;
    if (!good_) return;
    values.resize(count);
    ReadBytes(values.data(), count * sizeof values[0]);
  }
  bool good() const noexcept { return good_; }
  bool at_end() const noexcept { return rest_.empty(); }

 private:
  void ReadBytes(void* to, std::size_t count) {
    if (count > rest_.size()) good_ = false;
    if (!good_ || count == 0) return;
    std::memcpy(to, rest_.data(), count);
    rest_ = rest_.subspan(count);
  }

  std::span<const std::byte> rest_;
  bool good_ = true;
};

}  // namespace tandem
