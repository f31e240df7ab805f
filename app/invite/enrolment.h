#pragma once

#include <map>
#include <string>

#include "app/invite/invitation.h"
#include "app/invite/tls_endpoint.h"
#include "engine/base/result.h"

namespace tandem {

// The messages of an enrolment, inside TLS: the joiner's request, then the inviter's answer. Each
// is one line of JSON. Neither has the joiner's private key.

/// The files of a member's folder, by name.
using MemberFiles = std::map<std::string, std::string>;

/// The joiner asks for a certificate and proves that it has the line.
struct EnrolmentRequest {
  static constexpr std::size_t kLongest = 8192;  // bytes of the line of JSON

  Digest256 proof{};
  std::string certificate_request;  // PEM
};

/// The inviter gives the files that make a member, or says why it refuses.
struct EnrolmentAnswer {
  static constexpr std::size_t kLongest = std::size_t{1} << 20U;

  std::string refused;  // reason in a line; empty: the other members count
  std::string session;
  std::string name;  // member's name, chosen by the inviter
  Role role = Role::kActive;
  MemberFiles files;
};

/// Returns the proof that the joiner has the line, valid on this connection only. It is a keyed
/// digest over the connection's binding and the public part of the line. A line with another
/// session, role or time has another proof.
Digest256 ProofOf(const Invitation& invitation, const Digest256& binding);

std::string TextOf(const EnrolmentRequest& request);
std::string TextOf(const EnrolmentAnswer& answer);
/// Errors: the text is not such a message. Both texts come from the network.
Result<EnrolmentRequest> ReadEnrolmentRequest(const std::string& text);
Result<EnrolmentAnswer> ReadEnrolmentAnswer(const std::string& text);

}  // namespace tandem
