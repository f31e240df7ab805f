#include "collab/dds/security/security.h"

#include <array>
#include <utility>

namespace tandem {
namespace {

struct Plugin {
  const char* property;  // dds.sec.<property>.library.…
  const char* library;
  const char* function;  // init_…, finalize_…
};
constexpr std::array<Plugin, 3> kPlugins{{{"auth", "auth", "authentication"},
                                          {"access", "ac", "access_control"},
                                          {"crypto", "crypto", "crypto"}}};
constexpr std::array<std::pair<const char*, const char*>, 6> kFiles{{
    {"dds.sec.auth.identity_ca", "identity_ca.pem"},
    {"dds.sec.auth.identity_certificate", "identity.pem"},
    {"dds.sec.auth.private_key", "identity.key"},
    {"dds.sec.access.permissions_ca", "permissions_ca.pem"},
    {"dds.sec.access.governance", "governance.p7s"},
    {"dds.sec.access.permissions", "permissions.p7s"},
}};

}  // namespace

Result<Qos> SecureParticipantQos(const MemberKeys& keys) {
  Qos qos(dds_create_qos());
  for (const Plugin& plugin : kPlugins) {
    const std::filesystem::path library =
        std::filesystem::path(TANDEM_DDS_PLUGINS) /
        ("libdds_security_" + std::string(plugin.library) + ".so");
    if (!std::filesystem::exists(library)) {
      return Error{library.string() + " is missing: as root, apt-get install libddsc0debian"};
    }
    const std::string prefix = "dds.sec." + std::string(plugin.property) + ".library.";
    const auto set = [&](const char* name, const std::string& value) {
      dds_qset_prop(qos.get(), (prefix + name).c_str(), value.c_str());
    };
    set("path", library.string());
    set("init", "init_" + std::string(plugin.function));
    set("finalize", "finalize_" + std::string(plugin.function));
  }
  for (const auto& [property, file] : kFiles) {
    const std::string value = "file:" + (keys.folder / file).string();
    dds_qset_prop(qos.get(), property, value.c_str());
  }
  if (!keys.revoked_certificates.empty()) {
    const std::string value = "file:" + keys.revoked_certificates.string();
    dds_qset_prop(qos.get(), "org.eclipse.cyclonedds.sec.auth.crl", value.c_str());
  }
  return qos;
}

std::string ExplainRefusal(const std::string& output, const MemberKeys& keys) {
  const auto has = [&output](const char* words) {
    return output.find(words) != std::string::npos;
  };
  const std::string who = keys.folder.string() + ": ";
  if (has("PKCS7") || has("smime") || has("signature")) {
    return who + "its governance or permissions are not signed by its permissions authority";
  }
  if (has("not yet valid")) {
    return who + "its certificate or permissions are not valid yet: set this machine's clock";
  }
  if (has("expired") || has("validity")) {
    return who + "its certificate or permissions have expired: make new ones with 'tandem keys'";
  }
  if (has("certificate") || has("Certificate")) {
    return who + "its certificate is not signed by its identity authority";
  }
  if (has("Not Allowed By Security") || has("not allowed") || has("ermission")) {
    return who + "the permissions of " + keys.name + " do not allow that role";
  }
  return who + "refused by DDS Security" + (output.empty() ? "" : " (" + output + ")");
}

}  // namespace tandem
