#include "collab/dds/keys.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <ctime>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <random>
#include <sstream>
#include <vector>

#include <sys/stat.h>

#include "collab/dds/member_request.h"
#include "collab/dds/openssl.h"
#include "collab/dds/permissions.h"
#include "collab/dds/revocation.h"
#include "collab/dds/signing.h"
#include "collab/dds/unfinished_folder.h"
#include "engine/base/regular_file.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxName = 64;
constexpr std::uintmax_t kLargestMemberFile = 1 << 18;  // bytes
constexpr const char* kAudienceMark = "audience.txt";   // file in the folder of an audience's
                                                        // session
constexpr std::array kMemberFiles{"identity_ca.pem", "permissions_ca.pem", "governance.p7s",
                                  "identity.pem",    "identity.key",       "permissions.p7s",
                                  "member.txt"};

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

// Returns why the two authorities are not separate, or true. Neither may have issued the other.
// Otherwise every certificate of a member leads to both, and a member could sign permissions for
// itself.
Result<bool> AreTwo(const fs::path& identity_ca, const fs::path& permissions_ca) {
  const Result<std::string> first = PublicKeyOf(identity_ca);
  if (!first) return Error{identity_ca.string() + ": " + first.error().what};
  const Result<std::string> second = PublicKeyOf(permissions_ca);
  if (!second) return Error{permissions_ca.string() + ": " + second.error().what};
  if (*first == *second) {
    return Error{
        "one authority for both identities and permissions is refused: any member could then "
        "sign permissions for itself"};
  }
  for (const fs::path& one : {identity_ca, permissions_ca}) {
    const fs::path& other = one == identity_ca ? permissions_ca : identity_ca;
    if (!IsSignedBy(one, one)) {
      return Error{one.string() +
                   ": an authority that another has issued is refused, since members' certificates "
                   "could lead to that one: take one that has signed itself"};
    }
    if (IsSignedBy(one, other)) {
      return Error{one.string() +
                   ": issued by the other authority, which is refused: any member "
                   "could then sign permissions for itself"};
    }
  }
  return true;
}

Result<bool> TakeOrMake(const Authority& given, const std::string& name, const Authority& own,
                        int days) {
  if (given.certificate.empty()) return MakeAuthority(name, own, days);
  const Result<bool> copied = CopyInto(given.certificate, own.certificate);
  return copied ? CopyInto(given.key, own.key) : copied;
}

// Returns the date "2026-11-22 19:04:15Z" that follows `word`; 0: there is none.
std::time_t DateIn(const std::string& text, const std::string& word) {
  const std::size_t at = text.find(word);
  std::tm utc{};
  if (at == std::string::npos ||
      strptime(text.c_str() + at + word.size(), "%Y-%m-%d %H:%M:%S", &utc) == nullptr) {
    return 0;
  }
  return timegm(&utc);
}

std::string DayAndTime(std::time_t time) {
  std::tm utc{};
  gmtime_r(&time, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M UTC", &utc);
  return text.data();
}

// The times between which keys are valid.
struct KeyTimes {
  std::time_t from = 0;
  std::time_t until = 0;
};

// Returns when all of these certificates are valid.
Result<KeyTimes> SharedTimes(const std::vector<fs::path>& certificates) {
  KeyTimes shared{0, std::numeric_limits<std::time_t>::max()};
  for (const fs::path& certificate : certificates) {
    const Result<std::string> dates = Openssl({"x509", "-in", certificate.string(), "-noout",
                                               "-startdate", "-enddate", "-dateopt", "iso_8601"});
    if (!dates) return Error{certificate.string() + ": " + dates.error().what};
    shared.from = std::max(shared.from, DateIn(*dates, "notBefore="));
    shared.until = std::min(shared.until, DateIn(*dates, "notAfter="));
  }
  return shared;
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
  Result<bool> done = AreTwo(identity.certificate, permissions.certificate);
  if (!done) return done.error();
  const Result<KeyTimes> authorities = SharedTimes({identity.certificate, permissions.certificate});
  if (!authorities) return authorities.error();
  const std::time_t now = std::time(nullptr);
  if (now >= authorities->until) {
    return Error{session.string() + ": the session's authorities ended on " +
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
    const Result<bool> two = AreTwo(identity.certificate, permissions.certificate);
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

Result<bool> MakeControlKeys(const fs::path& folder) {
  constexpr int kDays = 365;  // longer than a controller runs
  if (const Result<bool> made = MakeSessionKeys(folder, {}, {}, kDays); !made) return made;
  for (const bool controller : {true, false}) {
    const std::string name = controller ? "controller" : "host";
    const Result<PeerId> member =
        MakeKeys(folder, name, "peer", folder / name, kDays,
                 [&](PeerId id, std::time_t from, std::time_t until) {
                   return ControlPermissionsXml(name, id, controller, from, until);
                 });
    if (!member) return member.error();
  }
  fs::remove(IdentityAuthority(folder).key);
  fs::remove(PermissionsAuthority(folder).key);
  return true;
}

namespace {

constexpr std::time_t kWeek = 7 * kDaySeconds;

// Returns an error if another user can read the private key or replace it.
Result<bool> IsPrivate(const fs::path& folder) {
  const fs::path key = folder / "identity.key";
  struct stat status {};
  if (stat(key.c_str(), &status) != 0 || (status.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    return Error{key.string() +
                 ": others can read or change this private key: chmod 600 it, and "
                 "make new keys if others may have read it"};
  }
  if (stat(folder.c_str(), &status) != 0 || (status.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    return Error{folder.string() + ": others can change what is in this folder: chmod 700 it"};
  }
  return true;
}

Result<bool> IsValidNow(MemberKeys& keys, std::time_t now) {
  const Result<KeyTimes> times =
      SharedTimes({keys.folder / "identity.pem", keys.folder / "identity_ca.pem",
                   keys.folder / "permissions_ca.pem"});
  if (!times) return times.error();
  keys.not_after = times->until;
  if (now < times->from) {
    return Error{keys.folder.string() + ": these keys are not valid yet, but from " +
                 DayAndTime(times->from) + " on; this machine's clock says " + DayAndTime(now) +
                 ": set the clock"};
  }
  if (now >= keys.not_after) {
    return Error{keys.folder.string() + ": these keys ended on " + DayAndTime(keys.not_after) +
                 " (this machine's clock says " + DayAndTime(now) +
                 "): make new ones with 'tandem keys'"};
  }
  return true;
}

// Reads member.txt.
Result<MemberKeys> ReadMember(const fs::path& folder) {
  MemberKeys keys;
  keys.folder = fs::absolute(folder);
  constexpr std::uintmax_t kLargestMember = 4096;
  const Result<std::string> member = ReadWholeFile(folder / "member.txt", kLargestMember);
  if (!member) return member.error();
  std::istringstream words(*member);
  std::string id;
  std::string role;
  std::uint32_t protocol = 0;
  words >> keys.name >> id >> role >> protocol;
  const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), keys.peer, 16);
  if (!IsMemberName(keys.name) || error != std::errc() || end != id.data() + id.size() ||
      keys.peer == 0 || (role != "peer" && role != "viewer" && role != "relay")) {
    return Error{(folder / "member.txt").string() + ": not as 'tandem keys' wrote it"};
  }
  if (protocol != kProtocol) {
    return Error{folder.string() + ": these keys are for protocol " +
                 (protocol == 0 ? "4 or before" : std::to_string(protocol)) +
                 ", this program speaks " + std::to_string(kProtocol) +
                 ": make the session's keys anew with 'tandem keys session'"};
  }
  keys.role = role == "peer" ? Role::kActive : Role::kViewer;
  keys.relay = role == "relay";
  return keys;
}

}  // namespace

Result<MemberKeys> LoadMemberKeys(const fs::path& folder, std::time_t now) {
  if (!fs::is_directory(folder)) {
    return Error{folder.string() +
                 ": no such folder; 'tandem keys peer' or 'tandem keys viewer' makes it"};
  }
  for (const char* file : kMemberFiles) {
    if (!fs::is_regular_file(folder / file)) {
      return Error{folder.string() + ": " + file +
                   " is missing; 'tandem keys peer' or 'tandem keys viewer' makes such a folder"};
    }
  }
  if (const Result<bool> is_private = IsPrivate(folder); !is_private) return is_private.error();
  Result<MemberKeys> keys = ReadMember(folder);
  if (!keys) return keys;
  const Result<bool> two = AreTwo(folder / "identity_ca.pem", folder / "permissions_ca.pem");
  if (!two) return two.error();
  if (const Result<bool> valid = IsValidNow(*keys, now); !valid) return valid.error();
  Result<Revocations> lists = ReadRevocations(keys->folder);
  if (!lists) return lists.error();
  keys->revoked = std::move(lists->members);
  keys->revoked_certificates = std::move(lists->certificates);
  if (keys->revoked.contains(keys->peer)) {
    return Error{folder.string() + ": the keys of " + keys->name + " have been revoked"};
  }
  return keys;
}

Result<bool> AreOfTwoSessions(const fs::path& member, const fs::path& relay) {
  const Result<std::string> one = PublicKeyOf(member / "identity_ca.pem");
  if (!one) return Error{member.string() + ": " + one.error().what};
  const Result<std::string> other = PublicKeyOf(relay / "identity_ca.pem");
  if (!other) return Error{relay.string() + ": " + other.error().what};
  if (*one != *other) return true;
  return Error{relay.string() + ": of the same authority as " + member.string() +
               ": make the relay's keys in a session with authorities of its own, 'tandem keys "
               "session FOLDER --audience'"};
}

std::string EndOfKeys(const MemberKeys& keys, std::time_t now) {
  constexpr std::time_t kLeaveBefore = 2;  // s
  if (keys.not_after == 0 || now + kLeaveBefore < keys.not_after) return {};
  return "the keys of " + keys.name +
         " have ended, and with them your part in the session: make new ones with 'tandem keys'";
}

std::string ExpiryWarning(const MemberKeys& keys, std::time_t now) {
  if (keys.not_after == 0 || keys.not_after - now >= kWeek) return {};
  return "the keys of " + keys.name + " end on " + DayAndTime(keys.not_after) +
         ": make new ones with 'tandem keys'";
}

}  // namespace tandem
