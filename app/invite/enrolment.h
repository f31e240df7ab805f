#pragma once

#include <map>
#include <string>

#include "app/invite/invitation.h"
#include "app/invite/tls_end.h"
#include "engine/base/result.h"

namespace tandem {

// What the two ends of an enrolment say to one another, within TLS: a request, then an answer, each
// one line of JSON. The joiner's private key is in neither.

/// Files of a member's folder by name.
using MemberFiles = std::map<std::string, std::string>;

/// The joiner asks for a certificate and shows that it has the line.
struct EnrolmentRequest {
  static constexpr std::size_t kLongest = 8192;  // bytes of the line of JSON

  Digest256 proof{};
  std::string certificate_request;  // PEM
};

/// The inviter gives what makes a member, or says why not.
struct EnrolmentAnswer {
  static constexpr std::size_t kLongest = std::size_t{1} << 20U;

  std::string refused;  // reason, in a line; empty: the rest counts
  std::string session;
  std::string name;  // the member's, which the inviter has chosen
  Role role = Role::kActive;
  MemberFiles files;
};

/// What shows that one has the line, on this connection and no other: a keyed digest over all of
/// the line that is no secret, so that a line with another session, role or time is another one.
Digest256 ProofOf(const Invitation& invitation, const Digest256& binding);

std::string TextOf(const EnrolmentRequest& request);
std::string TextOf(const EnrolmentAnswer& answer);
/// Errors: it is no such line. Either comes from the network.
Result<EnrolmentRequest> ReadEnrolmentRequest(const std::string& text);
Result<EnrolmentAnswer> ReadEnrolmentAnswer(const std::string& text);

}  // namespace tandem
