#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace tandem {

/// A SHA-256 digest. It identifies bytes whatever peer sent them.
using FileDigest = std::array<std::uint8_t, 32>;

FileDigest FileDigestOf(std::span<const char> bytes);
/// Returns 64 hexadecimal digits.
std::string HexOf(const FileDigest& digest);

/// Computes the SHA-256 digest of bytes that come in parts.
class RunningDigest {
 public:
  RunningDigest();
  ~RunningDigest();
  RunningDigest(const RunningDigest&) = delete;
  RunningDigest& operator=(const RunningDigest&) = delete;

  void Add(std::span<const char> bytes);
  /// Returns the digest of all bytes added; the last call.
  FileDigest Value();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tandem
