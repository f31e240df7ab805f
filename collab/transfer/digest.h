#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace tandem {

/// A SHA-256: who knows it knows the bytes, whoever sent them.
using FileDigest = std::array<std::uint8_t, 32>;

FileDigest FileDigestOf(std::span<const char> bytes);
/// 64 hexadecimal digits.
std::string HexOf(const FileDigest& digest);

/// A SHA-256 of bytes that come one after the other.
class RunningDigest {
 public:
  RunningDigest();
  ~RunningDigest();
  RunningDigest(const RunningDigest&) = delete;
  RunningDigest& operator=(const RunningDigest&) = delete;

  void Add(std::span<const char> bytes);
  /// Of all that was added; the last call.
  FileDigest Value();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem
