#pragma once

#include <ctime>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "collab/dds/security/signing.h"
#include "collab/session/messages.h"
#include "engine/base/result.h"

namespace tandem {

/// Says who takes part in a session: its members, or the audience of viewers behind a relay.
enum class SessionKind : std::uint8_t { kMembers, kAudience };

/// Makes a session's folder: two authorities and the signed governance. Given authorities take the
/// place of new ones (an empty path: none given). The same authority for both is refused, because a
/// member could then sign permissions with its own certificate (CVE-2023-24011). A file in the
/// folder marks the session of an audience.
Result<bool> MakeSessionKeys(const std::filesystem::path& folder, const Authority& identity = {},
                             const Authority& permissions = {}, int days = 3650,
                             SessionKind kind = SessionKind::kMembers);

/// Returns whether a member may have this name: letters, digits, '.', '_' and '-', at most 64.
bool IsMemberName(const std::string& name);

/// Makes a member's folder `out`, with all that the member needs to join and nothing else. It has
/// certificate and private key, both authorities' certificates, governance, its permissions, its
/// name and id. `name` is as IsMemberName() wants it. The keys end with the session's authorities
/// at the latest. In an audience's session nobody takes part, so keys of a peer are refused there.
Result<PeerId> MakeMemberKeys(const std::filesystem::path& session, const std::string& name,
                              Role role, const std::filesystem::path& out, int days = 365);

/// Signs the request of a person who keeps the private key. Returns the files of the member's
/// folder by name, without that key. `request` (PEM) is what MakeMemberRequest() made there. Only a
/// key of the sort that MakeMemberRequest() makes is signed; name, role and id are chosen here.
Result<std::map<std::string, std::string>> SignMember(const std::filesystem::path& session,
                                                      const std::string& name, Role role,
                                                      const std::string& request, int days = 365);

/// Makes the keys of a relay (tandem relay) in the session of its audience. There the relay may
/// speak as each peer that it shows. In the members' own session such keys would let their owner
/// speak as every member, so they are refused there.
Result<PeerId> MakeRelayKeys(const std::filesystem::path& session, const std::string& name,
                             const std::filesystem::path& out, int days = 365);

/// A checked member's folder. It is complete, only its owner can read the private key, and it has
/// two authorities. It is of this protocol and valid now, and its member.txt is well-formed.
struct MemberKeys {
  std::filesystem::path folder;  // absolute
  std::string name;
  PeerId peer = 0;
  Role role = Role::kActive;
  bool relay = false;                          // true: the keys are a relay's, which has no role
  std::time_t not_after = 0;                   // end of the first certificate that ends
  std::set<PeerId> revoked;                    // members whose keys are revoked
  std::filesystem::path revoked_certificates;  // certificate revocation list (CRL); empty: there is
                                               // none
};
Result<MemberKeys> LoadMemberKeys(const std::filesystem::path& folder,
                                  std::time_t now = std::time(nullptr));

/// Returns an error where one identity authority has signed both the keys of a relay in a session
/// (`member`) and its keys among its audience (`relay`). Both are folders of members.
Result<bool> AreOfTwoSessions(const std::filesystem::path& member,
                              const std::filesystem::path& relay);

/// Returns a line for the user if the keys end within two seconds, else an empty text. The program
/// must leave its session then. Cyclone 0.10 deletes the entities of a participant whose keys end
/// and may never free its readers, so leaving later can wait for ever.
std::string EndOfKeys(const MemberKeys& keys, std::time_t now = std::time(nullptr));

/// Returns a line for the user if the keys end within a week, else an empty text.
std::string ExpiryWarning(const MemberKeys& keys, std::time_t now = std::time(nullptr));

}  // namespace tandem
