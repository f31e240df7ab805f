#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "collab/dds/keys.h"
#include "engine/base/result.h"

namespace tandem {

// How somebody becomes a member whose private key never leaves the own machine: it makes a key and
// a request there, the session's owner signs the request (SignMember()), and the files that come
// back make the folder.

/// Makes a private key in a file and gives the request (PEM) that goes to the session's owner.
Result<std::string> MakeMemberRequest(const std::filesystem::path& key);

/// Looks at a request that a stranger may have written: signed by its own key, which is of the sort
/// that MakeMemberRequest() makes (elliptic curve P-256), and short.
Result<bool> CheckMemberRequest(const std::filesystem::path& request);

/// A digest of a file's bytes in groups of four letters, short enough to be compared on the
/// telephone: sixteen hexadecimal digits of its SHA-256.
Result<std::string> DigestToCompare(const std::filesystem::path& file);

/// Makes a member's folder of a private key and of what the session's owner signed, for its owner
/// alone and whole or not at all. `beside`: further files for the folder. Errors: the folder is
/// there, the certificate is of another key or of another authority, something is missing.
Result<MemberKeys> TakeMember(const std::filesystem::path& key,
                              const std::map<std::string, std::string>& files,
                              const std::filesystem::path& folder,
                              const std::map<std::string, std::string>& beside = {});

}  // namespace tandem
