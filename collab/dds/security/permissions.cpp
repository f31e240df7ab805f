#include "collab/dds/security/permissions.h"

#include <array>
#include <cstdio>
#include <vector>

#include "collab/dds/cyclone/partitions.h"

namespace tandem {
namespace {

// Any domain, because sessions are separated by their authorities.
constexpr const char* kEveryDomain =
    "<domains><id_range><min>0</min><max>230</max></id_range></domains>";

std::string Instant(std::time_t time) {
  std::tm utc{};
  gmtime_r(&time, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &utc);
  return text.data();
}

std::string Allow(const char* action, const std::vector<std::string>& topics,
                  const std::string& partition) {
  std::string xml = std::string("<") + action + "><topics>";
  for (const std::string& topic : topics) xml += "<topic>" + topic + "</topic>";
  return xml + "</topics><partitions><partition>" + partition + "</partition></partitions></" +
         action + ">";
}

// Returns a member's permissions: the rules, and nothing else.
std::string Grant(const std::string& name, PeerId peer, std::time_t from, std::time_t until,
                  const std::string& rules) {
  return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<dds>\n<permissions>\n<grant name=\"" + name +
         "\">\n<subject_name>" + SubjectOf(name, peer) + "</subject_name>\n<validity><not_before>" +
         Instant(from) + "</not_before><not_after>" + Instant(until) +
         "</not_after></validity>\n<allow_rule>\n" + kEveryDomain + "\n" + rules +
         "</allow_rule>\n<default>DENY</default>\n</grant>\n</permissions>\n</dds>\n";
}

}  // namespace

std::string SubjectOf(const std::string& name, PeerId peer) {
  std::array<char, 17> digits{};
  std::snprintf(digits.data(), digits.size(), "%016llx", static_cast<unsigned long long>(peer));
  return "O=Tandem,OU=" + std::string(digits.data()) + ",CN=" + name;
}

std::string GovernanceXml() {
  return std::string(
             "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<dds>\n<domain_access_rules>\n"
             "<domain_rule>\n") +
         kEveryDomain +
         "\n<allow_unauthenticated_participants>false</allow_unauthenticated_participants>\n"
         "<enable_join_access_control>true</enable_join_access_control>\n"
         "<discovery_protection_kind>ENCRYPT</discovery_protection_kind>\n"
         "<liveliness_protection_kind>SIGN</liveliness_protection_kind>\n"
         "<rtps_protection_kind>SIGN_WITH_ORIGIN_AUTHENTICATION</rtps_protection_kind>\n"
         "<topic_access_rules>\n<topic_rule>\n<topic_expression>*</topic_expression>\n"
         "<enable_discovery_protection>true</enable_discovery_protection>\n"
         "<enable_liveliness_protection>true</enable_liveliness_protection>\n"
         "<enable_read_access_control>true</enable_read_access_control>\n"
         "<enable_write_access_control>true</enable_write_access_control>\n"
         "<metadata_protection_kind>NONE</metadata_protection_kind>\n"
         "<data_protection_kind>ENCRYPT</data_protection_kind>\n"
         "</topic_rule>\n</topic_access_rules>\n</domain_rule>\n</domain_access_rules>\n</dds>\n";
}

std::string PermissionsXml(const std::string& name, PeerId peer, Role role, std::time_t from,
                           std::time_t until) {
  std::string rules;
  if (role == Role::kViewer) {
    const std::string own = ViewerPartition(peer);
    rules += Allow("publish", {"viewer_info"}, NamedPartition(own, name)) + "\n";
    rules += Allow("publish", {"review/*"}, own) + "\n";
    rules += Allow("subscribe", {"peer_info", "review/*", "file/*"}, kEveryPeer) + "\n";
  } else {
    const std::string own = PeerPartition(peer);
    const std::vector<std::string> moving{"state/1", "link/2", "event", "review/*", "file/*"};
    rules += Allow("publish", {"peer_info"}, NamedPartition(own, name)) + "\n";
    rules += Allow("publish", moving, own) + "\n";
    rules += Allow("publish", {"view/1"}, ViewPartition(peer)) + "\n";
    rules += Allow("publish", {"scene"}, ScenePartition(peer)) + "\n";
    rules += Allow("subscribe", moving, kEveryPeer) + "\n";
    rules += Allow("subscribe", {"peer_info"}, kEveryPeer) + "\n";
  }
  rules += Allow("subscribe", {"viewer_info", "review/*"}, kEveryViewer) + "\n";
  rules += Allow("subscribe", {"view/1"}, kEveryView) + "\n";
  rules += Allow("subscribe", {"scene"}, kEveryScene) + "\n";
  return Grant(name, peer, from, until, rules);
}

std::string RelayPermissionsXml(const std::string& name, PeerId peer, std::time_t from,
                                std::time_t until) {
  return Grant(name, peer, from, until,
               Allow("publish", {"peer_info", "review/*", "file/*"}, kEveryPeer) + "\n" +
                   Allow("publish", {"view/1"}, kEveryView) + "\n" +
                   Allow("publish", {"scene"}, kEveryScene) + "\n");
}

}  // namespace tandem
