#pragma once

#include <ctime>
#include <filesystem>
#include <set>
#include <string>

#include <sys/stat.h>

#include "collab/session/messages.h"
#include "engine/base/result.h"

namespace tandem {

/// A certificate and its private key, as files (PEM), to sign other certificates with.
struct Authority {
  std::filesystem::path certificate;
  std::filesystem::path key;
};

/// Returns the place of a session's authority in its folder.
Authority IdentityAuthority(const std::filesystem::path& session);
Authority PermissionsAuthority(const std::filesystem::path& session);

inline constexpr int kDaySeconds = 86400;

/// Makes new files private to their owner while it lives, so that private keys are so from their
/// first byte.
class OwnerOnly {
 public:
  OwnerOnly() : before_(umask(0077)) {}
  ~OwnerOnly() { umask(before_); }
  OwnerOnly(const OwnerOnly&) = delete;
  OwnerOnly& operator=(const OwnerOnly&) = delete;

 private:
  mode_t before_;
};

/// Writes a file in place. It is for folders that are put into their place as a whole.
Result<bool> WriteText(const std::filesystem::path& file, const std::string& text);

/// Returns a peer's id as certificates and lists have it: sixteen hexadecimal digits.
std::string SerialOf(PeerId peer);

/// Makes a new private key and its request for a certificate.
Result<bool> MakeRequest(const std::string& subject, const std::filesystem::path& key,
                         const std::filesystem::path& request);

/// Signs a request. The certificate is valid to `until`, and from a day back because clocks differ.
/// With `itself` an authority signs with its own key. `subject` replaces the request's, in the form
/// of MakeRequest(); empty: the request's own. Nothing else that the request asks for counts.
Result<bool> SignRequest(const std::filesystem::path& request, const Authority& authority,
                         bool itself, PeerId serial, std::time_t until,
                         const std::filesystem::path& out, const std::string& subject = {});

/// Returns whether the key of `by` has signed `certificate`; both may be one.
bool IsSignedBy(const std::filesystem::path& certificate, const std::filesystem::path& by);

/// Signs a document (S/MIME, as DDS Security wants it) with an authority's key.
Result<bool> SignDocument(const std::string& text, const Authority& authority,
                          const std::filesystem::path& out);

/// Writes the list (CRL) of revoked certificates for the plug-ins. It is valid from a day back,
/// because clocks differ.
Result<bool> WriteCertificateList(const Authority& authority, const std::set<PeerId>& revoked,
                                  const std::filesystem::path& out);

}  // namespace tandem
