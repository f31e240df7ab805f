#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "app/invite/enrolment.h"

namespace tandem {

/// Why an enrolment failed.
struct EnrolmentFault {
  enum class Kind : std::uint8_t {
    kUnreachable,  // no host answers
    kStranger,     // a program other than the inviter's answers
    kRefused       // the inviter refuses
  };
  Kind kind = Kind::kUnreachable;
  std::string what;  // description in a line
};

/// An inviter's answer, or the fault that prevented it.
struct EnrolmentOutcome {
  EnrolmentAnswer answer;
  std::optional<EnrolmentFault> fault;
};

/// Asks the inviter of a secured session to sign a certificate request (PEM). Connects to all of
/// its hosts at once. Sends nothing to a host whose certificate is not the line's. Takes at most
/// ten seconds, plus the time to resolve names; ends early on `stopped`.
EnrolmentOutcome Enrol(
    const Invitation& invitation, const std::string& certificate_request,
    const std::function<bool()>& stopped = [] {
      return false;
    });

/// The result of an attempt to reach the inviter that does not use the secret.
struct InviterFacts {
  std::string host;  // host that answered; empty: none
  bool is_the_inviter = false;
  std::string what;  // description in a line
};
InviterFacts ProbeInviter(const Invitation& invitation);

}  // namespace tandem
