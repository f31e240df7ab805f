#include "collab/dds/permissions.h"

#include <array>
#include <cstdio>
#include <vector>

#include "collab/dds/partitions.h"

namespace tandem {
namespace {

// Any domain: sessions are kept apart by their authorities.
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
         "<rtps_protection_kind>SIGN</rtps_protection_kind>\n"
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
  std::string xml =
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<dds>\n<permissions>\n<grant name=\"" + name +
      "\">\n<subject_name>" + SubjectOf(name, peer) + "</subject_name>\n<validity><not_before>" +
      Instant(from) + "</not_before><not_after>" + Instant(until) + "</not_after></validity>\n";
  xml += std::string("<allow_rule>\n") + kEveryDomain + "\n";
  if (role == Role::kViewer) {
    xml += Allow("publish", {"peer_info"}, PeerPartition(peer)) + "\n";
    xml += Allow("subscribe", {"peer_info"}, kEveryPeer) + "\n";
  } else {
    const std::vector<std::string> own{"state/1", "link/1", "event", "peer_info"};
    xml += Allow("publish", own, PeerPartition(peer)) + "\n";
    xml += Allow("publish", {"view/1"}, ViewPartition(peer)) + "\n";
    xml += Allow("publish", {"scene"}, kScenePartition) + "\n";
    xml += Allow("subscribe", own, kEveryPeer) + "\n";
  }
  xml += Allow("subscribe", {"view/1"}, kEveryView) + "\n";
  xml += Allow("subscribe", {"scene"}, kScenePartition) + "\n";
  return xml + "</allow_rule>\n<default>DENY</default>\n</grant>\n</permissions>\n</dds>\n";
}

}  // namespace tandem
