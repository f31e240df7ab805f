#include "collab/dds/security/member_request.h"

#include <set>
#include <utility>

#include "collab/dds/security/openssl.h"
#include "collab/dds/security/signing.h"
#include "collab/dds/security/unfinished_folder.h"
#include "engine/base/files/regular_file.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestRequest = 4096;  // bytes
constexpr std::size_t kLargestFile = 1 << 18;
// The beginning of every public key of the curve P-256 as a text (PEM). The algorithm, the curve
// and the mark of a whole point take exactly these letters; the point follows.
constexpr const char* kP256 = "-----BEGIN PUBLIC KEY-----\nMFkwEwYHKoZIzj0CAQYIKoZIzj0DAQcDQgAE";

Error NoRequest(const fs::path& request, const std::string& what) {
  return Error{request.filename().string() + ": " + what +
               ": 'tandem join' or 'tandem keys request' makes one"};
}

// Returns whether a session's owner gives a file of that name: one of a member's folder or a
// revocation list.
bool MayBeGiven(const std::string& name) {
  static const std::set<std::string> names{
      "identity_ca.pem", "permissions_ca.pem", "governance.p7s", "identity.pem",
      "permissions.p7s", "member.txt",         "revoked.p7s",    "identity.crl"};
  return names.contains(name);
}

Result<bool> FitsKey(const fs::path& folder) {
  const Result<std::string> own =
      Openssl({"pkey", "-in", (folder / "identity.key").string(), "-pubout"});
  if (!own) return own.error();
  const Result<std::string> certified = PublicKeyOf(folder / "identity.pem");
  if (!certified) return certified.error();
  if (*own != *certified) {
    return Error{"the certificate that came back is of another key: ask for a new invitation"};
  }
  if (!IsSignedBy(folder / "identity.pem", folder / "identity_ca.pem")) {
    return Error{
        "the certificate that came back is not signed by the session's authority: ask for a new "
        "invitation"};
  }
  return true;
}

}  // namespace

Result<std::string> MakeMemberRequest(const fs::path& key) {
  const OwnerOnly owner_only;
  const fs::path request = key.string() + ".csr";
  // its subject does not count
  if (const Result<bool> made = MakeRequest("/O=Tandem/CN=request", key, request); !made) {
    return made.error();
  }
  Result<std::string> text = ReadWholeFile(request, kLargestRequest);
  std::error_code ignored;
  fs::remove(request, ignored);
  return text;
}

Result<bool> CheckMemberRequest(const fs::path& request) {
  if (const Result<std::string> text = ReadWholeFile(request, kLargestRequest); !text) {
    return text.error();
  }
  const Result<std::string> verified =
      Openssl({"req", "-in", request.string(), "-noout", "-verify"});
  if (!verified || verified->find("verify OK") == std::string::npos) {
    return NoRequest(request, "no request for a certificate, or not signed by its own key");
  }
  const Result<std::string> key = Openssl({"req", "-in", request.string(), "-noout", "-pubkey"});
  if (!key || !key->starts_with(kP256)) {
    return NoRequest(request, "its key is of another sort than the curve P-256");
  }
  return true;
}

Result<std::string> DigestToCompare(const fs::path& file) {
  const Result<std::string> digest = Openssl({"dgst", "-sha256", "-r", file.string()});
  if (!digest) return Error{file.string() + ": " + digest.error().what};
  std::string groups;
  for (std::size_t i = 0; i < 16 && i < digest->size(); i += 4) {
    groups += (i == 0 ? "" : "-") + digest->substr(i, 4);
  }
  return groups;
}

Result<MemberKeys> TakeMember(const fs::path& key, const std::map<std::string, std::string>& files,
                              const fs::path& folder,
                              const std::map<std::string, std::string>& beside) {
  const OwnerOnly owner_only;
  for (const auto& [name, text] : files) {
    if (MayBeGiven(name) && text.size() <= kLargestFile) continue;
    return Error{"what came back has a file that is none of a member's folder"};
  }
  Result<UnfinishedFolder> made = UnfinishedFolder::Make(folder);
  if (!made) return made.error();
  const fs::path& out = made->path();
  const Result<std::string> own_key = ReadWholeFile(key, kLargestFile);
  if (!own_key) return own_key.error();
  Result<bool> done = WriteText(out / "identity.key", *own_key);
  for (const auto& [name, text] : files) {
    if (done) done = WriteText(out / name, text);
  }
  for (const auto& [name, text] : beside) {
    if (done) done = WriteText(out / name, text);
  }
  if (done) done = FitsKey(out);
  if (!done) return done.error();
  Result<MemberKeys> keys = LoadMemberKeys(out);
  if (!keys) return keys;
  if (done = made->Commit(); !done) return done.error();
  return LoadMemberKeys(folder);
}

}  // namespace tandem
