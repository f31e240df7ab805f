#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

namespace tandem {

/// A SHA-256 digest. It identifies bytes whoever made them: nobody finds two contents with one
/// digest.
using Sha256 = std::array<std::uint8_t, 32>;

/// Computes the SHA-256 digest of bytes that come in parts.
class RunningSha256 {
 public:
  RunningSha256();
  ~RunningSha256();
  RunningSha256(const RunningSha256&) = delete;
  RunningSha256& operator=(const RunningSha256&) = delete;

  void Add(std::span<const char> bytes) { AddBytes(bytes.data(), bytes.size()); }
  void AddBytes(const void* data, std::size_t size);
  void Add(std::integral auto value) { AddBytes(&value, sizeof value); }
  void Add(double value) { AddBytes(&value, sizeof value); }
  void Add(const Sha256& digest) { AddBytes(digest.data(), digest.size()); }
  /// Adds the length of a text, then the text, so that no two sequences of texts look alike.
  void AddText(std::string_view text);
  /// Returns the digest of all bytes added; the last call.
  Sha256 Value();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

Sha256 Sha256Of(std::span<const char> bytes);
/// Returns the digest of the length and of the digests of one megabyte after another, which are
/// computed in parallel: for gigabytes.
Sha256 Sha256OfMany(std::span<const std::byte> bytes);

}  // namespace tandem
