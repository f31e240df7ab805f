#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "collab/messages.h"
#include "engine/base/result.h"

namespace tandem {

/// A member whose keys are not valid any more.
struct RevokedMember {
  std::string name;
  PeerId peer = 0;
};

/// Adds a member to the list of those whose keys are not valid any more: the signed revoked.p7s and
/// identity.crl in the session's folder. Who has them in its own folder does not let that member in
/// and hears nothing of it, so all that stay must get both files. `member`: a member's folder, or
/// where there is none of that name, a name or an id from the session's list of its members
/// (members.txt). Errors: another authority has signed that folder's certificate, nobody of that
/// name has keys, several have.
Result<RevokedMember> RevokeMember(const std::filesystem::path& session, const std::string& member);

/// Adds to the session's list of its members (members.txt) one who is `part` in it: "peer",
/// "viewer" or "relay". A whole line is added, or nothing is.
Result<bool> AddToMembers(const std::filesystem::path& session, const std::string& name,
                          PeerId peer, const std::string& part);

/// Who is revoked by the lists in a folder.
struct Revocations {
  std::set<PeerId> members;
  std::filesystem::path certificates;  // their list (CRL); empty: there is none
};

/// Reads the lists in a session's or a member's folder. Errors: the permissions authority of the
/// folder has not signed them, or they are no files.
Result<Revocations> ReadRevocations(const std::filesystem::path& folder);

}  // namespace tandem
