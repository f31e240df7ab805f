#include "collab/dds/security/revocation.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <sstream>
#include <string_view>
#include <vector>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "collab/dds/security/keys.h"
#include "collab/dds/security/openssl.h"
#include "collab/dds/security/signing.h"
#include "collab/dds/security/unfinished_folder.h"
#include "engine/base/files/regular_file.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestList = 1 << 20;     // bytes
constexpr std::uintmax_t kLargestMembers = 1 << 24;  // bytes of kMembers
// in a session's folder, a line for each member with keys: name, id and part
constexpr const char* kMembers = "members.txt";

// Tells whether the folder has the list. The list is read once, because a pipe or a device under
// its name would block openssl and DDS for ever.
Result<bool> HasList(const fs::path& list) {
  std::error_code failed;
  if (fs::symlink_status(list, failed).type() == fs::file_type::not_found) return false;
  const Result<std::string> read = ReadWholeFile(list, kLargestList);
  if (!read) return read.error();
  return true;
}

// Reads an id of sixteen hexadecimal digits; 0: it is none.
PeerId IdOf(std::string_view digits) {
  PeerId peer = 0;
  const char* const end = digits.data() + digits.size();
  const auto [last, error] = std::from_chars(digits.data(), end, peer, 16);
  return digits.size() == 16 && error == std::errc() && last == end ? peer : 0;
}

// Reads the ids, one a line, that the permissions authority has signed as revoked. The authority
// signs with its own key: neither the system's authorities nor a certificate that it issued count.
Result<std::set<PeerId>> ReadRevoked(const fs::path& folder) {
  std::set<PeerId> revoked;
  const fs::path list = folder / "revoked.p7s";
  const Result<bool> there = HasList(list);
  if (!there) return there.error();
  if (!*there) return revoked;
  const std::string authority = (folder / "permissions_ca.pem").string();
  const Result<std::string> text = Openssl(
      {"smime", "-verify", "-text", "-in", list.string(), "-CAfile", authority, "-no-CApath",
       "-no-CAstore", "-nointern", "-certfile", authority, "-purpose", "any"});
  if (!text) {
    return Error{list.string() + ": is not signed by the permissions authority: get the session's"};
  }
  // openssl says first that all is well
  constexpr std::string_view kVerified = "Verification successful\n";
  std::istringstream lines(text->starts_with(kVerified) ? text->substr(kVerified.size()) : *text);
  std::string word;
  if (!(lines >> word) || word != "revoked") {
    return Error{list.string() + ": is no list of revoked members: get the session's"};
  }
  while (lines >> word) {
    if (const PeerId peer = IdOf(word); peer != 0) revoked.insert(peer);
  }
  return revoked;
}

// Returns the member that a certificate of the session's identity authority names. Nothing else in
// a member's folder is signed by that authority.
Result<RevokedMember> NamedBy(const fs::path& certificate, const fs::path& session) {
  std::error_code failed;
  if (!fs::is_regular_file(certificate, failed)) {
    return Error{certificate.string() +
                 ": no such file: name a member's folder, or the member itself"};
  }
  const fs::path authority = IdentityAuthority(session).certificate;
  if (!IsSignedBy(certificate, authority)) {
    return Error{certificate.string() + ": " + authority.string() +
                 " has not signed it: name a member of this session"};
  }
  const Result<std::string> output = Openssl({"x509", "-in", certificate.string(), "-noout",
                                              "-serial", "-subject", "-nameopt", "RFC2253"});
  if (!output) return Error{certificate.string() + ": " + output.error().what};
  // "serial=0123…", "subject=CN=anna,OU=0123…,O=Tandem"
  std::istringstream lines(*output);
  std::string serial;
  std::string subject;
  std::getline(lines, serial);
  std::getline(lines, subject);
  const std::size_t unit = subject.find(",OU=");
  constexpr std::string_view kSerial = "serial=";
  constexpr std::string_view kSubject = "subject=CN=";
  RevokedMember member;
  if (unit != std::string::npos && serial.starts_with(kSerial) && subject.starts_with(kSubject)) {
    const std::string digits = serial.substr(kSerial.size());
    // openssl leaves out zeros in front
    const std::size_t zeros = 16 - std::min<std::size_t>(16, digits.size());
    member.peer = IdOf(std::string(zeros, '0') + digits);
    member.name = subject.substr(kSubject.size(), unit - kSubject.size());
  }
  if (member.peer == 0 || member.peer != IdOf(std::string_view(subject).substr(unit + 4, 16))) {
    return Error{certificate.string() + ": not as 'tandem keys' wrote it"};
  }
  return member;
}

// Looks a name or an id up in the session's list of its members.
Result<RevokedMember> Listed(const fs::path& session, const std::string& wanted,
                             const std::set<PeerId>& revoked) {
  const fs::path list = session / kMembers;
  if (!IsMemberName(wanted)) {
    return Error{wanted + ": no such folder: name the member as " + list.string() + " does"};
  }
  const Result<std::string> text = ReadWholeFile(list, kLargestMembers);
  if (!text) return text.error();
  std::vector<RevokedMember> found;
  std::istringstream lines(*text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    RevokedMember member;
    std::string id;
    words >> member.name >> id;
    member.peer = IdOf(id);
    if (member.peer == 0 || (member.name != wanted && member.peer != IdOf(wanted))) continue;
    found.push_back(member);
  }
  if (found.empty()) {
    return Error{wanted + ": no such folder, and nobody of that name in " + list.string() +
                 ": name the member's folder"};
  }
  if (found.size() == 1) return found.front();
  // members that are revoked already are not meant, unless no other has the name
  std::vector<RevokedMember> valid = found;
  std::erase_if(valid, [&revoked](const RevokedMember& member) {
    return revoked.contains(member.peer);
  });
  if (valid.empty()) return found.front();
  if (valid.size() == 1) return valid.front();
  std::string ids;
  for (const RevokedMember& member : valid)
    ids += (ids.empty() ? "" : ", ") + SerialOf(member.peer);
  return Error{wanted + ": " + std::to_string(valid.size()) +
               " of that name have keys: name one by "
               "its id in " +
               list.string() + ", " + ids};
}

}  // namespace

Result<bool> AddToMembers(const fs::path& session, const std::string& name, PeerId peer,
                          const std::string& part) {
  const fs::path list = session / kMembers;
  const int file = open(list.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0600);
  int fault = file < 0 ? errno : 0;
  while (fault == 0 && flock(file, LOCK_EX) != 0) fault = errno == EINTR ? 0 : errno;
  struct stat before {};
  if (fault == 0 && fstat(file, &before) != 0) fault = errno;
  if (fault == 0) {
    char last = '\n';  // a line that a crash has cut off gets its end
    if (before.st_size > 0 && pread(file, &last, 1, before.st_size - 1) != 1) fault = EIO;
    const std::string line =
        (last == '\n' ? "" : "\n") + name + " " + SerialOf(peer) + " " + part + "\n";
    const ssize_t written = fault == 0 ? write(file, line.data(), line.size()) : -1;
    if (fault == 0 && written < 0) fault = errno;
    if (fault == 0 && static_cast<std::size_t>(written) != line.size()) fault = ENOSPC;
    if (fault == 0 && fsync(file) != 0) fault = errno;
    // remove half a line
    if (fault != 0 && ftruncate(file, before.st_size) != 0) fault = errno;
  }
  if (file >= 0) close(file);
  if (fault == 0 && before.st_size == 0) fault = SyncToDisk(session, true);
  if (fault == 0) return true;
  return Error{
      list.string() + ": cannot be written: " + std::strerror(fault) +
      "; no keys were made, because a member who is not in this file could not be revoked"};
}

Result<Revocations> ReadRevocations(const fs::path& folder) {
  Result<std::set<PeerId>> members = ReadRevoked(folder);
  if (!members) return members.error();
  const fs::path list = folder / "identity.crl";
  const Result<bool> there = HasList(list);
  if (!there) return there.error();
  return Revocations{*std::move(members), *there ? list : fs::path{}};
}

Result<RevokedMember> RevokeMember(const fs::path& session, const std::string& member) {
  const OwnerOnly owner_only;
  Result<std::set<PeerId>> revoked = ReadRevoked(session);
  if (!revoked) return revoked.error();
  std::error_code failed;
  const fs::path certificate = fs::path(member) / "identity.pem";
  const bool is_folder = fs::is_directory(member, failed) &&
                         (!IsMemberName(member) || fs::exists(certificate, failed));
  const Result<RevokedMember> named =
      is_folder ? NamedBy(certificate, session) : Listed(session, member, *revoked);
  if (!named) return named;
  revoked->insert(named->peer);
  std::string text = "revoked\n";
  for (const PeerId peer : *revoked) text += SerialOf(peer) + "\n";
  // neither list is put into its place before both are made; after a crash between the two a second
  // run makes both again
  const Result<UnfinishedFolder> unfinished = UnfinishedFolder::Make(session / "revocation");
  if (!unfinished) return unfinished.error();
  const fs::path members = unfinished->path() / "revoked.p7s";
  const fs::path certificates = unfinished->path() / "identity.crl";
  Result<bool> done = SignDocument(text, PermissionsAuthority(session), members);
  if (done) done = WriteCertificateList(IdentityAuthority(session), *revoked, certificates);
  for (const fs::path& made : {members, certificates}) {
    const int fault = done ? SyncToDisk(made, false) : 0;
    if (fault != 0) done = Error{made.string() + ": " + std::strerror(fault)};
  }
  for (const fs::path& made : {members, certificates}) {
    if (!done) return done.error();
    fs::rename(made, session / made.filename(), failed);
    if (failed) done = Error{made.string() + ": " + failed.message()};
  }
  if (!done) return done.error();
  static_cast<void>(SyncToDisk(session, true));
  return named;
}

}  // namespace tandem
