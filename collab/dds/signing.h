#pragma once

#include <ctime>
#include <filesystem>
#include <set>
#include <string>

#include <sys/stat.h>

#include "collab/messages.h"
#include "engine/base/result.h"

namespace tandem {

/// A certificate and its private key, as files (PEM), with which others are signed.
struct Authority {
  std::filesystem::path certificate;
  std::filesystem::path key;
};

/// Where a session's folder has its two authorities.
Authority IdentityAuthority(const std::filesystem::path& session);
Authority PermissionsAuthority(const std::filesystem::path& session);

inline constexpr int kDaySeconds = 86400;

/// Private keys are for their owner alone, from their first byte on.
class OwnerOnly {
 public:
  OwnerOnly() : before_(umask(0077)) {}
  ~OwnerOnly() { umask(before_); }
  OwnerOnly(const OwnerOnly&) = delete;
  OwnerOnly& operator=(const OwnerOnly&) = delete;

 private:
  mode_t before_;
};

/// Writes a file in place, for folders that are put into theirs as a whole.
Result<bool> WriteText(const std::filesystem::path& file, const std::string& text);

/// A peer's id as certificates and lists have it: sixteen hexadecimal digits.
std::string SerialOf(PeerId peer);

/// A new private key and what is to be signed of it.
Result<bool> MakeRequest(const std::string& subject, const std::filesystem::path& key,
                         const std::filesystem::path& request);

/// Signs a request; valid from a day back, for clocks differ, to `until`. Of an authority `itself`:
/// by its own key. `subject`: in place of the request's, as MakeRequest() takes it; empty: the
/// request's own. What else the request asks for counts for nothing.
Result<bool> SignRequest(const std::filesystem::path& request, const Authority& authority,
                         bool itself, PeerId serial, std::time_t until,
                         const std::filesystem::path& out, const std::string& subject = {});

/// Tells whether the key of `by` has signed `certificate`; both may be one.
bool IsSignedBy(const std::filesystem::path& certificate, const std::filesystem::path& by);

/// Signs a document (S/MIME, as DDS Security wants it) with an authority's key.
Result<bool> SignDocument(const std::string& text, const Authority& authority,
                          const std::filesystem::path& out);

/// The list (CRL) of certificates that are not valid any more, for the plug-ins. It is valid from a
/// day back, for clocks differ.
Result<bool> WriteCertificateList(const Authority& authority, const std::set<PeerId>& revoked,
                                  const std::filesystem::path& out);

}  // namespace tandem
