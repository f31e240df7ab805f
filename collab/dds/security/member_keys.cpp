#include <array>
#include <charconv>
#include <ctime>
#include <filesystem>
#include <sstream>
#include <string>
#include <utility>

#include <sys/stat.h>

#include "collab/dds/security/authorities.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/security/openssl.h"
#include "collab/dds/security/permissions.h"
#include "collab/dds/security/revocation.h"
#include "collab/dds/security/signing.h"
#include "engine/base/files/regular_file.h"
#include "engine/realtime/private_process.h"

// Loads the keys of a member and says how long they are valid; keys.cpp makes them.

namespace tandem {
namespace {

namespace fs = std::filesystem;

constexpr std::array kMemberFiles{"identity_ca.pem", "permissions_ca.pem", "governance.p7s",
                                  "identity.pem",    "identity.key",       "permissions.p7s",
                                  "member.txt"};
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
  // the permissions are those of protocol 5
  if (protocol != kProtocol && protocol != 5) {
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
  KeepProcessPrivate();  // the caller is about to use the keys
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
  const Result<bool> two = AreSeparate(folder / "identity_ca.pem", folder / "permissions_ca.pem");
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
