#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "collab/dds/security/keys.h"
#include "engine/base/result.h"

namespace tandem {

// The way by which a person becomes a member without sending a private key. The person's machine
// makes a key and a request. The session's owner signs the request (SignMember()), and the files
// that come back make the folder.

/// Makes a private key in a file and returns the request (PEM) for the session's owner.
Result<std::string> MakeMemberRequest(const std::filesystem::path& key);

/// Checks a request that a stranger may have written. It must be short and signed by its own key,
/// which must be of the sort that MakeMemberRequest() makes (elliptic curve P-256).
Result<bool> CheckMemberRequest(const std::filesystem::path& request);

/// Returns a digest of a file's bytes in groups of four letters, short enough to be compared on the
/// telephone: sixteen hexadecimal digits of its SHA-256.
Result<std::string> DigestToCompare(const std::filesystem::path& file);

/// Makes a member's folder from a private key and the files that the session's owner signed. Only
/// its owner can read it, and it is whole or not there. `beside` has further files for the folder.
/// Errors: the folder exists, the certificate is of another key or authority, or something is
/// missing.
Result<MemberKeys> TakeMember(const std::filesystem::path& key,
                              const std::map<std::string, std::string>& files,
                              const std::filesystem::path& folder,
                              const std::map<std::string, std::string>& beside = {});

}  // namespace tandem
