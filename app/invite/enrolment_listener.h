#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "app/invite/enrolment.h"

namespace tandem {

/// Makes a member of whoever showed the secret: signs the request, whose subject counts for
/// nothing.
using SignFunction = std::function<Result<MemberFiles>(const std::string& certificate_request)>;

/// Waits for the one who was invited, at a TCP port that anybody may reach. Whoever cannot show the
/// secret gets one and the same refusal, whatever it says, and is bounded in bytes, in time and in
/// number.
class EnrolmentListener {
 public:
  static constexpr int kMostConnections = 8;
  static constexpr int kMostWrong = 10;  // proofs, after which the invitation is closed
  static constexpr std::int64_t kConnectionNs = 8'000'000'000;  // a connection lasts, at the most

  enum class End : std::uint8_t { kUsed, kExpired, kGuessed, kStopped };

  /// Opens the port, or with `or_next` one of the next few where it is taken; 0: any.
  static Result<EnrolmentListener> Open(std::uint16_t port, bool or_next);
  EnrolmentListener(EnrolmentListener&& other) noexcept;
  EnrolmentListener& operator=(EnrolmentListener&&) = delete;
  ~EnrolmentListener();

  std::uint16_t port() const noexcept { return port_; }
  const Secret128& certificate() const noexcept { return identity_.digest(); }

  /// Answers until the invitation is used once, it is past its time, or `stop`. `name` is the
  /// member's. `tell`: a line about what came that was refused, once for each kind.
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
