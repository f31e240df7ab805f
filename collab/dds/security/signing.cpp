#include "collab/dds/security/signing.h"

#include <array>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <utility>
#include <vector>

#include "collab/dds/security/openssl.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

// Returns the time as `openssl ca` wants it.
std::string TimeOf(std::time_t time) {
  std::tm utc{};
  gmtime_r(&time, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y%m%d%H%M%SZ", &utc);
  return text.data();
}

// The database that `openssl ca` keeps of its signatures. A new one serves each signature or list.
class Books {
 public:
  explicit Books(const fs::path& beside) : folder_(beside / "unfinished") {}
  ~Books() {
    std::error_code failed;
    fs::remove_all(folder_, failed);
  }
  Books(const Books&) = delete;
  Books& operator=(const Books&) = delete;

  /// `entries` are lines of the index, one for each certificate.
  Result<bool> Open(const std::string& serial, const std::string& entries) {
    std::error_code failed;
    fs::remove_all(folder_, failed);
    fs::create_directories(folder_, failed);
    if (failed) return Error{folder_.string() + ": " + failed.message()};
    const std::string at = folder_.string();
    Result<bool> done = WriteText(folder_ / "index.txt", entries);
    if (done) done = WriteText(folder_ / "serial", serial + "\n");
    if (done) done = WriteText(folder_ / "crlnumber", "01\n");
    if (!done) return done;
    return WriteText(config(), "[ca]\ndefault_ca=d\n[d]\ndatabase=" + at +
                                   "/index.txt\nserial=" + at + "/serial\ncrlnumber=" + at +
                                   "/crlnumber\nnew_certs_dir=" + at +
                                   "\ndefault_md=sha256\npolicy=p\nemail_in_dn=no\n"
                                   "preserve=yes\nunique_subject=no\n[p]\n"
                                   "organizationName=optional\norganizationalUnitName=optional\n"
                                   "commonName=supplied\n[authority]\n"
                                   "basicConstraints=critical,CA:TRUE\n"
                                   "keyUsage=critical,keyCertSign,cRLSign,digitalSignature\n"
                                   "subjectKeyIdentifier=hash\n[member]\n"
                                   "basicConstraints=critical,CA:FALSE\n");
  }
  fs::path config() const { return folder_ / "ca.cnf"; }

 private:
  fs::path folder_;
};

}  // namespace

Result<bool> WriteText(const fs::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  if (!stream.flush()) return Error{file.string() + ": cannot be written"};
  return true;
}

Authority IdentityAuthority(const fs::path& session) {
  return {session / "identity_ca.pem", session / "identity_ca.key"};
}

Authority PermissionsAuthority(const fs::path& session) {
  return {session / "permissions_ca.pem", session / "permissions_ca.key"};
}

std::string SerialOf(PeerId peer) {
  std::array<char, 17> serial{};
  std::snprintf(serial.data(), serial.size(), "%016llX", static_cast<unsigned long long>(peer));
  return serial.data();
}

Result<bool> MakeRequest(const std::string& subject, const fs::path& key, const fs::path& request) {
  const Result<std::string> made =
      Openssl({"req", "-new", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
               "-sha256", "-subj", subject, "-keyout", key.string(), "-out", request.string()});
  if (!made) return made.error();
  return true;
}

Result<bool> SignRequest(const fs::path& request, const Authority& authority, bool itself,
                         PeerId serial, std::time_t until, const fs::path& out,
                         const std::string& subject) {
  Books books(out.parent_path());
  if (Result<bool> opened = books.Open(SerialOf(serial), ""); !opened) return opened;
  const std::time_t now = std::time(nullptr);
  std::vector<std::string> arguments{"ca",
                                     "-batch",
                                     "-notext",
                                     "-config",
                                     books.config().string(),
                                     "-in",
                                     request.string(),
                                     "-out",
                                     out.string(),
                                     "-keyfile",
                                     authority.key.string(),
                                     "-startdate",
                                     TimeOf(now - kDaySeconds),
                                     "-enddate",
                                     TimeOf(until),
                                     "-extensions",
                                     itself ? "authority" : "member"};
  if (itself) {
    arguments.emplace_back("-selfsign");
  } else {
    arguments.insert(arguments.end(), {"-cert", authority.certificate.string()});
  }
  if (!subject.empty()) arguments.insert(arguments.end(), {"-subj", subject});
  const Result<std::string> is_signed = Openssl(std::move(arguments));
  if (!is_signed) return is_signed.error();
  return true;
}

bool IsSignedBy(const fs::path& certificate, const fs::path& by) {
  return Openssl({"verify", "-partial_chain", "-no_check_time", "-trusted", by.string(),
                  certificate.string()})
      .has_value();
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

Result<bool> WriteCertificateList(const Authority& authority, const std::set<PeerId>& revoked,
                                  const fs::path& out) {
  const std::time_t now = std::time(nullptr);
  const std::string when = TimeOf(now - kDaySeconds).substr(2);
  const std::string far = TimeOf(now + std::time_t{3650} * kDaySeconds).substr(2);
  std::string entries;
  for (const PeerId peer : revoked) {
    entries += "R\t" + far + "\t" + when + "\t" + SerialOf(peer) + "\tunknown\t/CN=revoked\n";
  }
  Books books(out.parent_path());
  if (Result<bool> opened = books.Open("01", entries); !opened) return opened;
  const Result<std::string> made = Openssl(
      {"ca", "-gencrl", "-config", books.config().string(), "-keyfile", authority.key.string(),
       "-cert", authority.certificate.string(), "-crl_lastupdate", TimeOf(now - kDaySeconds),
       "-crl_nextupdate", TimeOf(now + std::time_t{3650} * kDaySeconds), "-out", out.string()});
  if (!made) return made.error();
  return true;
}

}  // namespace tandem
