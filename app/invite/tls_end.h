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

/// Bytes that nobody can guess. Error: the system gives none.
Result<Secret128> NewSecret();

/// A keyed digest (HMAC-SHA256): who does not have the secret cannot make it.
using Digest256 = std::array<std::uint8_t, 32>;
Digest256 KeyedDigest(const Secret128& secret, std::string_view text);

/// Compares in a time that does not tell where they differ.
bool AreSame(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b);

/// A key and a certificate that it has signed itself, in memory alone: a listener is known by the
/// certificate's digest, which its line has.
class TlsIdentity {
 public:
  static Result<TlsIdentity> Make();
  /// First half of the SHA-256 of the certificate.
  const Secret128& digest() const noexcept { return digest_; }

 private:
  friend class TlsEnd;
  struct Context;
  std::shared_ptr<Context> context_;
  Secret128 digest_{};
};

/// One end of a connection by TLS 1.3 and nothing older, without a socket: it turns bytes of the
/// network into text and back. The other end may send anything. Used by one thread.
class TlsEnd {
 public:
  static TlsEnd Server(const TlsIdentity& identity);
  static TlsEnd Client();
  TlsEnd(TlsEnd&&) noexcept;
  TlsEnd& operator=(TlsEnd&&) noexcept;
  ~TlsEnd();

  /// Takes what has come by the network.
  void Receive(std::span<const char> bytes);
  /// What is to be sent now.
  std::string TakeToSend();

  bool open() const noexcept { return open_; }      // both have agreed on keys
  bool failed() const noexcept { return failed_; }  // nothing more will come of it
  /// Of the other end's certificate, as TlsIdentity::digest(); zeros: it has none, or is not yet
  /// open.
  Secret128 others_digest() const;
  /// Bytes that only the two ends of this connection have: what is bound to them is of no use in
  /// another one. Once open.
  Digest256 Binding() const;
  void Say(std::string_view text);
  /// Text that has come since; once open.
  std::string Hear();
  /// Says that no more text follows.
  void Close();

 private:
  struct State;
  explicit TlsEnd(std::unique_ptr<State> state);
  void Advance();

  std::unique_ptr<State> state_;
  bool open_ = false;
  bool failed_ = false;
};

}  // namespace tandem
