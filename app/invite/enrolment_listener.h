#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

#include "app/invite/enrolment.h"

namespace tandem {

/// Makes a member of the joiner that proved it has the secret: signs its request, and ignores the
/// request's subject.
using SignFunction = std::function<Result<MemberFiles>(const std::string& certificate_request)>;

/// Waits for the invited joiner at a TCP port that strangers can reach. Every client without the
/// secret gets the same refusal, whatever it sends. Bytes, time and number of connections are
/// bounded.
class EnrolmentListener {
 public:
  static constexpr std::size_t kMostConnections = 32;
  static constexpr std::size_t kMostOfAnAddress = 8;  // connections of a client's address
  static constexpr int kMostWrong = 10;               // wrong proofs until the invitation is closed
  static constexpr std::int64_t kConnectionNs = 8'000'000'000;  // longest life of a connection

  enum class End : std::uint8_t { kUsed, kExpired, kGuessed, kStopped };

  /// Binds a TCP socket to a port. Returns false with errno set if it cannot.
  using BindFunction = std::function<bool(int socket, std::uint16_t port)>;

  /// Opens the port; 0: any. With `or_next`, tries the next few ports where it is taken. `bind`
  /// decides who reaches the port.
  static Result<EnrolmentListener> Open(std::uint16_t port, bool or_next, const BindFunction& bind);
  EnrolmentListener(EnrolmentListener&& other) noexcept;
  EnrolmentListener& operator=(EnrolmentListener&&) = delete;
  ~EnrolmentListener();

  std::uint16_t port() const noexcept { return port_; }
  const Secret128& certificate() const noexcept { return identity_.digest(); }

  /// Answers until the invitation was used once, has expired, met kMostWrong wrong proofs, or
  /// `stop` is set. `name` is the member's. `tell` gets a line about refused clients: the first
  /// wrong proof, and each other refusal.
  End Serve(const Invitation& invitation, const std::string& name, const SignFunction& sign,
            const std::function<void(const std::string&)>& tell, const std::atomic<bool>& stop);

 private:
  EnrolmentListener(int socket, std::uint16_t port, TlsIdentity identity)
      : socket_(socket), port_(port), identity_(std::move(identity)) {}

  int socket_;
  std::uint16_t port_;
  TlsIdentity identity_;
};

}  // namespace tandem
