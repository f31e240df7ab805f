#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tandem::driver::network {

/// A secret that both ends have, for codes over packets: HMAC-SHA-256 (RFC 2104), by OpenSSL.
class Key {
 public:
  using Code = std::array<std::uint8_t, 32>;

  Key() = default;
  explicit Key(std::vector<std::uint8_t> secret) : secret_(std::move(secret)) {}
  ~Key();
  Key(const Key&) = default;
  Key& operator=(const Key&) = default;

  /// Reads a file of mode 0600 that belongs to this user, without trailing white space. False:
  /// `fault` says why.
  bool Read(const std::string& file, std::string& fault);
  /// Makes a random secret. False: the machine gives no random numbers.
  bool Make();
  bool empty() const { return secret_.empty(); }
  Code CodeOf(std::span<const std::uint8_t> text) const;
  /// Returns whether the code is right, in a time that does not depend on the code.
  bool Holds(std::span<const std::uint8_t> text, std::span<const std::uint8_t> code) const;

 private:
  std::vector<std::uint8_t> secret_;
};

}  // namespace tandem::driver::network
