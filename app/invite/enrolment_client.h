#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "app/invite/enrolment.h"

namespace tandem {

/// Why an enrolment came to nothing.
struct EnrolmentFault {
  enum class Kind : std::uint8_t {
    kUnreachable,  // nobody answers
    kStranger,     // another program than the inviter's answers
    kRefused       // by the inviter
  };
  Kind kind = Kind::kUnreachable;
  std::string what;  // in a line
};

/// Either of the two.
struct EnrolmentOutcome {
  EnrolmentAnswer answer;
  std::optional<EnrolmentFault> fault;
};

/// Asks the inviter of a secured session to sign a certificate request (PEM), at all of its hosts
/// at once. Nothing is said to anybody whose certificate is not the line's. Takes ten seconds at
/// the most, but for names that are slow to resolve; ends early on `stopped`.
EnrolmentOutcome Enrol(
    const Invitation& invitation, const std::string& certificate_request,
    const std::function<bool()>& stopped = [] {
      return false;
    });

/// What a try to reach the inviter finds, without a word of the secret.
struct InviterFacts {
  std::string host;  // that answered; empty: none
  bool is_the_inviter = false;
  std::string what;  // in a line
};
InviterFacts ProbeInviter(const Invitation& invitation);

}  // namespace tandem
