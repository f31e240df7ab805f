#include "collab/dds/security/keys.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "collab/dds/security/authorities.h"
#include "collab/dds/security/member_request.h"
#include "collab/dds/security/permissions.h"
#include "collab/dds/security/revocation.h"
#include "collab/dds/security/signing.h"
#include "collab/dds/security/unfinished_folder.h"
#include "engine/base/files/regular_file.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxName = 64;
constexpr std::uintmax_t kLargestMemberFile = 1 << 18;  // bytes
constexpr const char* kAudienceMark = "audience.txt";   // file in the folder of an audience's
                                                        // session

Result<bool> CopyInto(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  fs::copy_file(from, to, failed);
  if (failed) return Error{from.string() + ": " + failed.message()};
  return true;
}

// Returns 64 random bits; the certificate binds them to the member.
PeerId NewPeerId() {
  std::random_device random;
  PeerId id = 0;
  while (id == 0) id = static_cast<PeerId>(random()) << 32U | random();
  return id;
}

Result<bool> MakeAuthority(const std::string& name, const Authority& out, int days) {
  const fs::path request = out.certificate.string() + ".csr";
  Result<bool> done = MakeRequest("/O=Tandem/CN=" + name, out.key, request);
  if (done) {
    const std::time_t until = std::time(nullptr) + std::time_t{days} * kDaySeconds;
    done = SignRequest(request, out, true, NewPeerId(), until, out.certificate);
  }
  std::error_code failed;
  fs::remove(request, failed);
  return done;
}

Result<bool> TakeOrMake(const Authority& given, const std::string& name, const Authority& own,
                        int days) {
  if (given.certificate.empty()) return MakeAuthority(name, own, days);
  const Result<bool> copied = CopyInto(given.certificate, own.certificate);
  return copied ? CopyInto(given.key, own.key) : copied;
}

// Makes a member's certificate. `given` is another person's request (PEM), whose subject does not
// count; empty: a new key is made.
Result<bool> MakeIdentity(const Authority& authority, const std::string& name, PeerId peer,
                          const fs::path& out, std::time_t until, const std::string& given) {
  std::string subject = "/";
  subject += SubjectOf(name, peer);
  std::ranges::replace(subject, ',', '/');
  const fs::path request = out / "identity.csr";
  Result<bool> done = given.empty() ? MakeRequest(subject, out / "identity.key", request)
                                    : WriteText(request, given);
  if (done && !given.empty()) done = CheckMemberRequest(request);
  if (done) {
    done = SignRequest(request, authority, false, peer, until, out / "identity.pem", subject);
  }
  std::error_code failed;
  fs::remove(request, failed);
  return done;
}

// A new member and its unfinished folder.
struct NewMember {
  PeerId peer = 0;
  UnfinishedFolder folder;
};

using PermissionsFunction = std::function<std::string(PeerId, std::time_t from, std::time_t until)>;

// Fills the folder of a member that is `part` in the session: "peer", "viewer" or "relay". Its keys
// end with the session's authorities at the latest. `request` is as for MakeIdentity().
Result<NewMember> FillFolder(const fs::path& session, const std::string& name,
                             const std::string& part, const fs::path& folder, int days,
                             const PermissionsFunction& permissions_of,
                             const std::string& request) {
  const OwnerOnly owner_only;
  if (!IsMemberName(name)) {
    return Error{"'" + name + "' is no name for a member: letters, digits, '.', '_', '-'"};
  }
  const Authority identity = IdentityAuthority(session);
  const Authority permissions = PermissionsAuthority(session);
  Result<bool> done = AreSeparate(identity.certificate, permissions.certificate);
  if (!done) return done.error();
  const Result<KeyTimes> authorities = SharedTimes({identity.certificate, permissions.certificate});
  if (!authorities) return authorities.error();
  const std::time_t now = std::time(nullptr);
  if (now >= authorities->until) {
    return Error{session.string() + ": the session's certificate authorities expired on " +
                 DayAndTime(authorities->until) +
                 ": make a new session with 'tandem keys session'"};
  }
  const std::time_t until = std::min(now + std::time_t{days} * kDaySeconds, authorities->until);
  Result<UnfinishedFolder> made = UnfinishedFolder::Make(folder);
  if (!made) return made.error();
  const fs::path& out = made->path();
  const PeerId peer = NewPeerId();
  if (done) done = MakeIdentity(identity, name, peer, out, until, request);
  if (done) {  // a day back, because clocks differ
    done = SignDocument(permissions_of(peer, now - kDaySeconds, until), permissions,
                        out / "permissions.p7s");
  }
  for (const char* shared : {"identity_ca.pem", "permissions_ca.pem", "governance.p7s"}) {
    if (done) done = CopyInto(session / shared, out / shared);
  }
  if (done) {
    std::array<char, 17> id{};
    std::snprintf(id.data(), id.size(), "%016llx", static_cast<unsigned long long>(peer));
    done = WriteText(out / "member.txt", name + " " + std::string(id.data()) + " " + part + " " +
                                             std::to_string(kProtocol) + "\n");
  }
  // members that are revoked already
  for (const char* list : {"revoked.p7s", "identity.crl"}) {
    if (done && fs::exists(session / list)) done = CopyInto(session / list, out / list);
  }
  // in the list before anybody has the keys
  if (done) done = AddToMembers(session, name, peer, part);
  if (!done) return done.error();
  return NewMember{peer, *std::move(made)};
}

Result<PeerId> MakeKeys(const fs::path& session, const std::string& name, const std::string& part,
                        const fs::path& folder, int days,
                        const PermissionsFunction& permissions_of) {
  const OwnerOnly owner_only;
  Result<NewMember> member = FillFolder(session, name, part, folder, days, permissions_of, {});
  if (!member) return member.error();
  if (const Result<bool> done = member->folder.Commit(); !done) return done.error();
  return member->peer;
}

// Returns an error where a peer's keys are asked for in an audience's session.
std::optional<Error> IsAudience(const fs::path& session, Role role) {
  if (role != Role::kActive || !fs::exists(session / kAudienceMark)) return std::nullopt;
  return Error{session.string() +
               ": these are the keys of those who look on behind a relay, where nobody takes "
               "part: name the session's own folder"};
}

}  // namespace

bool IsMemberName(const std::string& name) {
  return !name.empty() && name.size() <= kMaxName && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
}

Result<bool> MakeSessionKeys(const fs::path& folder, const Authority& identity,
                             const Authority& permissions, int days, SessionKind kind) {
  const OwnerOnly owner_only;
  // check before anything is made
  if (!identity.certificate.empty() && !permissions.certificate.empty()) {
    const Result<bool> two = AreSeparate(identity.certificate, permissions.certificate);
    if (!two) return two;
  }
  Result<UnfinishedFolder> made = UnfinishedFolder::Make(folder);
  if (!made) return made.error();
  const fs::path& out = made->path();
  Result<bool> done = TakeOrMake(identity, "Tandem identities", IdentityAuthority(out), days);
  if (done) {
    done = TakeOrMake(permissions, "Tandem permissions", PermissionsAuthority(out), days);
  }
  if (done) {
    done = SignDocument(GovernanceXml(), PermissionsAuthority(out), out / "governance.p7s");
  }
  if (done && kind == SessionKind::kAudience) {
    done = WriteText(out / kAudienceMark,
                     "The session of those who look on behind a relay: nobody takes part in it.\n");
  }
  return done ? made->Commit() : done;
}

Result<PeerId> MakeMemberKeys(const fs::path& session, const std::string& name, Role role,
                              const fs::path& out, int days) {
  if (const std::optional<Error> audience = IsAudience(session, role)) return *audience;
  return MakeKeys(session, name, role == Role::kViewer ? "viewer" : "peer", out, days,
                  [&](PeerId peer, std::time_t from, std::time_t until) {
                    return PermissionsXml(name, peer, role, from, until);
                  });
}

Result<std::map<std::string, std::string>> SignMember(const fs::path& session,
                                                      const std::string& name, Role role,
                                                      const std::string& request, int days) {
  const OwnerOnly owner_only;
  if (const std::optional<Error> audience = IsAudience(session, role)) return *audience;
  if (request.empty()) return Error{"the request for a certificate is empty"};
  // never committed: its files go to the person who has the key
  const Result<NewMember> member = FillFolder(
      session, name, role == Role::kViewer ? "viewer" : "peer", session / "invited", days,
      [&](PeerId peer, std::time_t from, std::time_t until) {
        return PermissionsXml(name, peer, role, from, until);
      },
      request);
  if (!member) return member.error();
  std::map<std::string, std::string> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(member->folder.path())) {
    Result<std::string> text = ReadWholeFile(entry.path(), kLargestMemberFile);
    if (!text) return text.error();
    files[entry.path().filename().string()] = *std::move(text);
  }
  return files;
}

Result<PeerId> MakeRelayKeys(const fs::path& session, const std::string& name, const fs::path& out,
                             int days) {
  if (!fs::exists(session / kAudienceMark)) {
    return Error{session.string() +
                 ": with a relay's keys of this session one could speak as each of its members: "
                 "make those who look on a session of their own, 'tandem keys session FOLDER "
                 "--audience', and name that folder"};
  }
  return MakeKeys(session, name, "relay", out, days,
                  [&](PeerId peer, std::time_t from, std::time_t until) {
                    return RelayPermissionsXml(name, peer, from, until);
                  });
}

}  // namespace tandem
