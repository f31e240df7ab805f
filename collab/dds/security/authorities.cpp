#include "collab/dds/security/authorities.h"

#include <algorithm>
#include <array>
#include <limits>

#include "collab/dds/security/openssl.h"
#include "collab/dds/security/signing.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;

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

}  // namespace

Result<bool> AreSeparate(const fs::path& identity_ca, const fs::path& permissions_ca) {
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

std::string DayAndTime(std::time_t time) {
  std::tm utc{};
  gmtime_r(&time, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M UTC", &utc);
  return text.data();
}

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

}  // namespace tandem
