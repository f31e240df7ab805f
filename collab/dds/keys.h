#pragma once

#include <ctime>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "collab/dds/signing.h"
#include "collab/messages.h"
#include "engine/base/result.h"

namespace tandem {

/// Says whose session it is: of those who take part, or of those who look on behind a relay.
enum class SessionKind : std::uint8_t { kMembers, kAudience };

/// Makes a session's folder: two authorities of its own and the signed governance. Given ones take
/// the place of new ones (an empty path: none given). One for both is refused: a member could then
/// sign permissions with its own certificate (CVE-2023-24011). A file in the folder says that the
/// session is an audience's.
Result<bool> MakeSessionKeys(const std::filesystem::path& folder, const Authority& identity = {},
                             const Authority& permissions = {}, int days = 3650,
                             SessionKind kind = SessionKind::kMembers);

/// Whether a member may be called so: letters, digits, '.', '_' and '-', not too many.
bool IsMemberName(const std::string& name);

/// Makes a member's folder `out`, with all that it needs to join and nothing else: certificate and
/// private key, both authorities' certificates, governance, its permissions, its name and id.
/// `name` is letters, digits, '.', '_' and '-'. The keys end with the session's authorities at the
/// latest. In an audience's session nobody takes part: keys of a peer are refused there.
Result<PeerId> MakeMemberKeys(const std::filesystem::path& session, const std::string& name,
                              Role role, const std::filesystem::path& out, int days = 365);

/// The same for somebody who keeps the private key: the folder's files by name, without that one.
/// `request` (PEM) is what MakeMemberRequest() made there. Its key is looked at, of which nothing
/// but the sort that we make is signed; name, role and id are ours.
Result<std::map<std::string, std::string>> SignMember(const std::filesystem::path& session,
                                                      const std::string& name, Role role,
                                                      const std::string& request, int days = 365);

/// The same for a relay (tandem relay) in the session of those who look on behind it: it may speak
/// there as each peer that it shows. In the members' own session such keys would let their owner
/// speak as every member, so they are refused there.
Result<PeerId> MakeRelayKeys(const std::filesystem::path& session, const std::string& name,
                             const std::filesystem::path& out, int days = 365);

/// Makes the keys of one controller and its hosts, for as long as it runs: authorities of their own
/// in `folder`, which must be empty or not there, and the members' folders `controller` and `host`
/// in it. The authorities' private keys are removed again: nobody gets keys later.
Result<bool> MakeControlKeys(const std::filesystem::path& folder);

/// A member's folder, checked: complete, its private key nobody else's to read, two authorities, of
/// this protocol, valid now, its own words well-formed.
struct MemberKeys {
  std::filesystem::path folder;  // absolute
  std::string name;
  PeerId peer = 0;
  Role role = Role::kActive;
  bool relay = false;                          // then it has no role
  std::time_t not_after = 0;                   // of the first certificate that ends
  std::set<PeerId> revoked;                    // members whose keys are not valid any more
  std::filesystem::path revoked_certificates;  // a list (CRL); empty: there is none
};
Result<MemberKeys> LoadMemberKeys(const std::filesystem::path& folder,
                                  std::time_t now = std::time(nullptr));

/// Returns an error where one identity authority has signed both: the keys of a relay in a session
/// (`member`) and among those who look on behind it (`relay`). Folders of members.
Result<bool> AreOfTwoSessions(const std::filesystem::path& member,
                              const std::filesystem::path& relay);

/// What there is to say of keys that end within two seconds, in a line; empty: nothing. Whoever is
/// in a session must leave it then: Cyclone 0.10 deletes the entities of a participant whose keys
/// end and may never free its readers, so whoever leaves after that waits for ever.
std::string EndOfKeys(const MemberKeys& keys, std::time_t now = std::time(nullptr));

/// What there is to say of keys that end within a week, in a line; empty: nothing.
std::string ExpiryWarning(const MemberKeys& keys, std::time_t now = std::time(nullptr));

}  // namespace tandem
