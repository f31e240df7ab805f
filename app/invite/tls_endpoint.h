#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "app/invite/invitation.h"
#include "engine/base/result.h"

namespace tandem {

/// Returns random bytes that cannot be guessed. Error: the system gives none.
Result<Secret128> NewSecret();

/// A keyed digest (HMAC-SHA256). Only a program with the secret can make it.
using Digest256 = std::array<std::uint8_t, 32>;
Digest256 KeyedDigest(const Secret128& secret, std::string_view text);

/// Compares in constant time, so that the time does not tell where the texts differ.
bool AreSame(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b);

/// A key and its self-signed certificate, in memory alone. A listener is identified by the
/// certificate's digest, which the line has.
class TlsIdentity {
 public:
  static Result<TlsIdentity> Make();
  /// Returns the first half of the SHA-256 of the certificate.
  const Secret128& digest() const noexcept { return digest_; }

 private:
  friend class TlsEndpoint;
  struct Context;
  std::shared_ptr<Context> context_;
  Secret128 digest_{};
};

/// One end of a TLS 1.3 connection, without a socket: converts network bytes to text and back.
/// Refuses older versions. The other end may send anything. Used by one thread.
class TlsEndpoint {
 public:
  static TlsEndpoint Server(const TlsIdentity& identity);
  static TlsEndpoint Client();
  TlsEndpoint(TlsEndpoint&&) noexcept;
  TlsEndpoint& operator=(TlsEndpoint&&) noexcept;
  ~TlsEndpoint();

  /// Takes bytes that came from the network.
  void Receive(std::span<const char> bytes);
  /// Returns the bytes to send now.
  std::string TakeToSend();

  bool open() const noexcept { return open_; }      // handshake done
  bool failed() const noexcept { return failed_; }  // failed or closed by the other end
  /// Returns the digest of the other end's certificate, as TlsIdentity::digest(). Zeros: it has
  /// none, or the connection is not open yet.
  Secret128 others_digest() const;
  /// Returns bytes that only the two ends of this connection have. A proof made with them is
  /// useless on another connection. The connection must be open.
  Digest256 Binding() const;
  void Say(std::string_view text);
  /// Returns the text received since the last call; empty until the connection is open.
  std::string Hear();
  /// Tells the other end that no more text follows.
  void Close();

 private:
  struct State;
  explicit TlsEndpoint(std::unique_ptr<State> state);
  void Advance();

  std::unique_ptr<State> state_;
  bool open_ = false;
  bool failed_ = false;
};

}  // namespace tandem
