#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "collab/session/messages.h"
#include "engine/base/result.h"

namespace tandem {

/// A member whose keys are revoked.
struct RevokedMember {
  std::string name;
  PeerId peer = 0;
};

/// Revokes a member: adds it to the signed lists revoked.p7s and identity.crl in the session's
/// folder. A program with these files in its own folder does not let that member in and ignores it.
/// So all remaining members must get both files. `member` is a member's folder. If that folder does
/// not exist, it is a name or an id from the session's list of its members (members.txt). Errors:
/// another authority has signed that folder's certificate, nobody of that name has keys, or several
/// members have.
/// members have.
Result<RevokedMember> RevokeMember(const std::filesystem::path& session, const std::string& member);

/// Adds a member to the session's list of its members (members.txt). `part` is "peer", "viewer" or
/// "relay". Either a whole line is added or nothing.
Result<bool> AddToMembers(const std::filesystem::path& session, const std::string& name,
                          PeerId peer, const std::string& part);

/// The members that the lists in a folder revoke.
struct Revocations {
  std::set<PeerId> members;
  std::filesystem::path certificates;  // their certificate revocation list (CRL); empty: there is
                                       // none
};

/// Reads the lists in a session's or a member's folder. Errors: the folder's permissions authority
/// has not signed them, or they are not regular files.
Result<Revocations> ReadRevocations(const std::filesystem::path& folder);

}  // namespace tandem
