#include "collab/dds/keys.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <ctime>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>

#include <sys/stat.h>

#include "collab/dds/openssl.h"
#include "collab/dds/permissions.h"
#include "collab/dds/unfinished_folder.h"
#include "engine/base/regular_file.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxName = 64;
constexpr int kDaySeconds = 86400;
constexpr std::array kMemberFiles{"identity_ca.pem", "permissions_ca.pem", "governance.p7s",
                                  "identity.pem",    "identity.key",       "permissions.p7s",
                                  "member.txt"};

// Private keys are for their owner alone, from their first byte on.
class OwnerOnly {
 public:
  OwnerOnly() : before_(umask(0077)) {}
  ~OwnerOnly() { umask(before_); }
  OwnerOnly(const OwnerOnly&) = delete;
  OwnerOnly& operator=(const OwnerOnly&) = delete;

 private:
  mode_t before_;
};

Result<bool> WriteText(const fs::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  if (!stream.flush()) return Error{file.string() + ": cannot be written"};
  return true;
}

Result<bool> CopyInto(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  fs::copy_file(from, to, failed);
  if (failed) return Error{from.string() + ": " + failed.message()};
  return true;
}

Result<bool> MakeAuthority(const std::string& name, const Authority& out, int days) {
  const Result<std::string> made =
      Openssl({"req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
               "-nodes", "-sha256", "-days", std::to_string(days), "-subj", "/O=Tandem/CN=" + name,
               "-keyout", out.key.string(), "-out", out.certificate.string()});
  if (!made) return made.error();
  return true;
}

// Why the two are one, or nothing.
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
  return true;
}

Result<bool> TakeOrMake(const Authority& given, const std::string& name, const Authority& own,
                        int days) {
  if (given.certificate.empty()) return MakeAuthority(name, own, days);
  const Result<bool> copied = CopyInto(given.certificate, own.certificate);
  return copied ? CopyInto(given.key, own.key) : copied;
}

Authority IdentityAuthority(const fs::path& session) {
  return {session / "identity_ca.pem", session / "identity_ca.key"};
}
Authority PermissionsAuthority(const fs::path& session) {
  return {session / "permissions_ca.pem", session / "permissions_ca.key"};
}

// 64 random bits; the certificate binds them to the member.
PeerId NewPeerId() {
  std::random_device random;
  PeerId id = 0;
  while (id == 0) id = static_cast<PeerId>(random()) << 32U | random();
  return id;
}

Result<bool> MakeIdentity(const Authority& authority, const std::string& name, PeerId peer,
                          const fs::path& out, int days) {
  std::string subject = "/";
  subject += SubjectOf(name, peer);
  std::ranges::replace(subject, ',', '/');
  const fs::path request = out / "identity.csr";
  Result<std::string> done =
      Openssl({"req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
               "-sha256", "-subj", subject, "-keyout", (out / "identity.key").string(), "-out",
               request.string()});
  if (!done) return done.error();
  std::array<char, 19> serial{};
  std::snprintf(serial.data(), serial.size(), "0x%016llx", static_cast<unsigned long long>(peer));
  done = Openssl({"x509", "-req", "-in", request.string(), "-CA", authority.certificate.string(),
                  "-CAkey", authority.key.string(), "-set_serial", serial.data(), "-days",
                  std::to_string(days), "-sha256", "-out", (out / "identity.pem").string()});
  if (!done) return done.error();
  fs::remove(request);
  return true;
}

// A folder for one who is `part` in the session: "peer", "viewer" or "relay".
Result<PeerId> MakeKeys(
    const fs::path& session, const std::string& name, const std::string& part,
    const fs::path& folder, int days,
    const std::function<std::string(PeerId, std::time_t from, std::time_t until)>& permissions_of) {
  const OwnerOnly owner_only;
  if (!IsMemberName(name)) {
    return Error{"'" + name + "' is no name for a member: letters, digits, '.', '_', '-'"};
  }
  const Authority identity = IdentityAuthority(session);
  const Authority permissions = PermissionsAuthority(session);
  Result<bool> done = AreTwo(identity.certificate, permissions.certificate);
  if (!done) return done.error();
  Result<UnfinishedFolder> made = UnfinishedFolder::Make(folder);
  if (!made) return made.error();
  const fs::path& out = made->path();
  const PeerId peer = NewPeerId();
  if (done) done = MakeIdentity(identity, name, peer, out, days);
  const std::time_t now = std::time(nullptr);
  if (done) {  // a day back: clocks differ
    done =
        SignDocument(permissions_of(peer, now - kDaySeconds, now + std::time_t{days} * kDaySeconds),
                     permissions, out / "permissions.p7s");
  }
  for (const char* shared : {"identity_ca.pem", "permissions_ca.pem", "governance.p7s"}) {
    if (done) done = CopyInto(session / shared, out / shared);
  }
  if (done) {
    std::array<char, 17> id{};
    std::snprintf(id.data(), id.size(), "%016llx", static_cast<unsigned long long>(peer));
    done = WriteText(out / "member.txt", name + " " + std::string(id.data()) + " " + part + "\n");
  }
  if (done) done = made->Commit();
  if (!done) return done.error();
  return peer;
}

}  // namespace

bool IsMemberName(const std::string& name) {
  return !name.empty() && name.size() <= kMaxName && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
}

Result<bool> SignDocument(const std::string& text, const Authority& authority,
                          const fs::path& out) {
  const fs::path plain = out.string() + ".xml";
  if (const Result<bool> written = WriteText(plain, text); !written) return written;
  const Result<std::string> is_signed =
      Openssl({"smime", "-sign", "-in", plain.string(), "-text", "-out", out.string(), "-signer",
               authority.certificate.string(), "-inkey", authority.key.string()});
  fs::remove(plain);
  if (!is_signed) return is_signed.error();
  return true;
}

Result<bool> MakeSessionKeys(const fs::path& folder, const Authority& identity,
                             const Authority& permissions, int days) {
  const OwnerOnly owner_only;
  // before anything is made
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
  return done ? made->Commit() : done;
}

Result<PeerId> MakeMemberKeys(const fs::path& session, const std::string& name, Role role,
                              const fs::path& out, int days) {
  return MakeKeys(session, name, role == Role::kViewer ? "viewer" : "peer", out, days,
                  [&](PeerId peer, std::time_t from, std::time_t until) {
                    return PermissionsXml(name, peer, role, from, until);
                  });
}

Result<PeerId> MakeRelayKeys(const fs::path& session, const std::string& name, const fs::path& out,
                             int days) {
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

Result<MemberKeys> LoadMemberKeys(const fs::path& folder) {
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
  MemberKeys keys;
  keys.folder = fs::absolute(folder);
  constexpr std::uintmax_t kLargestMember = 4096;
  const Result<std::string> member = ReadWholeFile(folder / "member.txt", kLargestMember);
  if (!member) return member.error();
  std::istringstream words(*member);
  std::string id;
  std::string role;
  words >> keys.name >> id >> role;
  const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), keys.peer, 16);
  if (!IsMemberName(keys.name) || error != std::errc() || end != id.data() + id.size() ||
      keys.peer == 0 || (role != "peer" && role != "viewer" && role != "relay")) {
    return Error{(folder / "member.txt").string() + ": not as 'tandem keys' wrote it"};
  }
  keys.role = role == "peer" ? Role::kActive : Role::kViewer;
  keys.relay = role == "relay";
  const Result<bool> two = AreTwo(folder / "identity_ca.pem", folder / "permissions_ca.pem");
  if (!two) return two.error();
  return keys;
}

}  // namespace tandem
