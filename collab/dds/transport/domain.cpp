#include "collab/dds/transport/domain.h"

#include <array>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <set>

#include <arpa/inet.h>
#include <dlfcn.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <unistd.h>

#include "collab/dds/cyclone/cyclone_log.h"
#include "collab/dds/cyclone/cyclone_threads.h"
#include "collab/dds/cyclone/socket_drops.h"
#include "collab/dds/cyclone/waiting_instances.h"
#include "collab/dds/networks/domain_networks.h"
#include "collab/dds/networks/network_watch.h"
#include "collab/dds/transport/receive_thread.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/text/markup.h"

extern "C" {
struct ddsi_typeid;
struct ddsi_typeinfo;
bool ddsi_typeid_is_hash(const ddsi_typeid* type);
const ddsi_typeid* ddsi_typeinfo_minimal_typeid(const ddsi_typeinfo* info);
const ddsi_typeid* ddsi_typeinfo_complete_typeid(const ddsi_typeinfo* info);

// Replaces Cyclone's function, because Cyclone finds this one before its own. An announced writer
// whose type is of an unknown kind makes 0.10.2 end the program, and anybody can announce one.
bool ddsi_typeinfo_valid(const ddsi_typeinfo* info) {
  static const auto cyclones =
      reinterpret_cast<decltype(&ddsi_typeinfo_valid)>(dlsym(RTLD_NEXT, "ddsi_typeinfo_valid"));
  return ddsi_typeid_is_hash(ddsi_typeinfo_minimal_typeid(info)) &&
         ddsi_typeid_is_hash(ddsi_typeinfo_complete_typeid(info)) && cyclones(info);
}
}

namespace tandem {
namespace {

constexpr const char* kLoopback = "lo";
// Bytes. A controller's snapshot has at most 0.25 MB, all else is smaller (idl).
constexpr int kLargestSample = 512 * 1024;

bool IsPlain(char c) {  // independent of the locale
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

// Returns why `name` is not an interface to use, or nothing.
std::optional<Error> CheckInterface(const std::string& name) {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return Error{"cannot list the network interfaces"};
  std::set<std::string> usable;
  bool exists = false;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    exists = exists || name == i->ifa_name;
    const bool has_address = i->ifa_addr != nullptr && i->ifa_addr->sa_family == AF_INET;
    if (has_address && (i->ifa_flags & IFF_UP) != 0) usable.insert(i->ifa_name);
  }
  freeifaddrs(list);
  if (usable.contains(name)) return std::nullopt;

  std::string names;
  for (const std::string& one : usable) names += (names.empty() ? "" : ", ") + one;
  if (names.empty()) names = "none";
  const std::string fault = exists
                                ? "network interface '" + name + "' is down or has no IPv4 address"
                                : "there is no network interface '" + name + "'";
  return Error{fault + " (usable: " + names + ")"};
}

bool IsIpv4(const std::string& text) {
  in_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1;
}

// Returns why no address of a host is found, or nothing.
std::optional<Error> CheckHost(const std::string& host) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int failed = getaddrinfo(host.c_str(), nullptr, &hints, &found);
  if (failed != 0) return Error{"--peers: no IPv4 address is known for '" + host + "'"};
  freeaddrinfo(found);
  return std::nullopt;
}

bool PortIsFree(std::uint16_t port) {
  const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return true;  // Cyclone will report it
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  const bool free = bind(probe, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  close(probe);
  return free;
}

// Returns why an own port cannot be used, or nothing.
std::optional<Error> CheckPort(std::uint16_t port) {
  if (port == 0) return std::nullopt;
  for (const std::uint32_t one : {std::uint32_t{port}, std::uint32_t{port} + 1}) {
    if (one > 65535 || !PortIsFree(static_cast<std::uint16_t>(one))) {
      return Error{"--port " + std::to_string(port) + ": UDP port " + std::to_string(one) +
                   (one > 65535 ? " does not exist" : " is taken by another program")};
    }
  }
  return std::nullopt;
}

// Returns the address of the network that leads to the others, as far as that can be known.
std::uint32_t AnnouncedAddress(const DdsOptions& options) {
  const NetworkTable& networks = CurrentNetworks();
  for (const NetworkTable::Row& row : networks.used()) {
    if (options.interface == row.name.data()) return row.address;
  }
  for (const std::string& text : options.peers) {
    const Result<PeerAddress> peer = ParsePeerAddress(text);
    in_addr address{};
    if (!peer || inet_pton(AF_INET, peer->host.c_str(), &address) != 1) continue;
    if (const std::uint32_t own = SourceTowards(address.s_addr); own != 0) return own;
  }
  // where the default route leads, and where the discovery group would be looked for
  for (const char* const far : {"192.0.2.1", "239.255.0.1"}) {
    if (const std::uint32_t own = SourceTowards(inet_addr(far)); own != 0) return own;
  }
  for (const NetworkTable::Row& row : networks.used()) {
    if (!row.loopback) return row.address;
  }
  return htonl(INADDR_LOOPBACK);
}

std::string PortsXml(std::uint16_t port) {
  // index 0 of a domain without an offset: exactly `port` and the next
  return "<Ports><Base>" + std::to_string(port) +
         "</Base><DomainGain>0</DomainGain><UnicastMetaOffset>0</UnicastMetaOffset>"
         "<UnicastDataOffset>1</UnicastDataOffset><MulticastMetaOffset>2</MulticastMetaOffset>"
         "<MulticastDataOffset>3</MulticastDataOffset></Ports>";
}

std::string PeersXml(const DdsOptions& options, bool loopback) {
  std::string xml = "<Peers>";
  if (loopback && options.peers.empty()) xml += "<Peer address=\"127.0.0.1\"/>";
  for (const std::string& text : options.peers) {
    const Result<PeerAddress> peer = ParsePeerAddress(text);
    if (!peer) continue;  // CheckOptions has reported it
    // with a port of our own, the others are taken to have the same
    const std::uint16_t port = peer->port != 0 ? peer->port : options.port;
    xml += "<Peer address=\"" + EscapedMarkup(peer->host);
    if (port != 0) xml.append(":").append(std::to_string(port));
    xml += "\"/>";
  }
  return xml + "</Peers>";
}

}  // namespace

Result<PeerAddress> ParsePeerAddress(const std::string& text) {
  const Error bad{"--peers: '" + text + "' is not HOST or HOST:PORT (IPv4)"};
  const std::size_t colon = text.find(':');
  PeerAddress peer{.host = text.substr(0, colon), .port = 0};
  for (const char c : peer.host) {
    if (!IsPlain(c)) return bad;
  }
  if (peer.host.empty()) return bad;
  if (colon == std::string::npos) return peer;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + colon + 1, end, peer.port);
  if (error != std::errc() || stop != end || peer.port == 0) return bad;
  return peer;
}

std::string WhyNoSessionName(const std::string& name) {
  if (name.empty()) return "a session needs a name";
  if (name.size() > kMaxSessionName) {
    return "the session's name is longer than " + std::to_string(kMaxSessionName) + " bytes";
  }
  if (!IsPlainText(name)) {
    return "the session's name is no plain text: it has control characters, or bytes that are no "
           "UTF-8";
  }
  return {};
}

std::optional<Error> CheckOptions(const DdsOptions& options) {
  if (std::string fault = WhyNoSessionName(options.session); !fault.empty()) {
    return Error{std::move(fault)};
  }
  if (options.domain > kMaxDomain) {
    return Error{"there is no DDS domain " + std::to_string(options.domain) +
                 ": they go from 0 to " + std::to_string(kMaxDomain)};
  }
  if (!options.interface.empty()) {
    if (std::optional<Error> error = CheckInterface(options.interface)) return error;
  }
  for (const std::string& text : options.peers) {
    const Result<PeerAddress> peer = ParsePeerAddress(text);
    if (!peer) return peer.error();
    if (std::optional<Error> error = CheckHost(peer->host)) return error;
  }
  if (!options.external_address.empty() && !IsIpv4(options.external_address)) {
    return Error{"--external-address: '" + options.external_address + "' is not an IPv4 address"};
  }
  return CheckPort(options.port);
}

std::string DiscoveryTag(const std::string& session) {
  std::string tag = "tandem/";
  for (const char c : session) {
    if (IsPlain(c)) {
      tag += c;
    } else {
      std::array<char, 4> code{};
      std::snprintf(code.data(), code.size(), "%%%02X",
                    static_cast<unsigned>(static_cast<unsigned char>(c)));
      tag += code.data();
    }
  }
  return tag;
}

std::string DomainXml(const DdsOptions& options, bool real_time_receive) {
  const bool loopback = options.interface == kLoopback;
  const bool multicast = !loopback && options.peers.empty();
  std::string xml = "<Domain Id=\"any\"><General>";
  // elsewhere Cyclone sees one network, which leads to all that the domain is on (networks)
  if (loopback) xml += "<Interfaces><NetworkInterface name=\"lo\"/></Interfaces>";
  xml += std::string("<AllowMulticast>") + (multicast ? "true" : "false") + "</AllowMulticast>";
  if (!options.external_address.empty()) {
    xml += "<ExternalNetworkAddress>" + options.external_address + "</ExternalNetworkAddress>";
  }
  // many routers drop fragments of IP packets
  if (!options.peers.empty() || options.port != 0 || !options.external_address.empty()) {
    xml += "<MaxMessageSize>1400 B</MaxMessageSize><FragmentSize>1300 B</FragmentSize>";
  }
  xml += "</General><Discovery><Tag>" + DiscoveryTag(options.session) + "</Tag>";
  if (options.port != 0) {
    xml += "<ParticipantIndex>0</ParticipantIndex>" + PortsXml(options.port);
  } else {
    xml += "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>" +
           std::to_string(kLastProgramIndex) + "</MaxAutoParticipantIndex>";
  }
  xml += "<LeaseDuration>2 s</LeaseDuration>";
  // after a cut longer than the lease, all programs are discovered again by their next
  // announcement. Cyclone's own come every 1.6 s, but peers that are back are to be known within a
  // second. They must not come more often than kLivelinessLeaseNs, because an announcement is a
  // sign of life, also of a peer that has given us up. Loopback is never cut, and would have each
  // announcement sent to every port
  if (!loopback) xml += "<SPDPInterval>650 ms</SPDPInterval>";
  if (!multicast) xml += PeersXml(options, loopback);
  // a writer that ends waits so long for readers that have not acknowledged all. A killed reader
  // never does, and after one second, Cyclone's default, the program has been ended by force
  xml += "</Discovery><Internal><WriterLingerDuration>300 ms</WriterLingerDuration>";
  // a socket keeps the packets that come while the receive thread does not run. With seven peers at
  // 1 kHz that is some 0.2 s, or less where the kernel allows less
  xml += std::string("<MultipleReceiveThreads>") +
         (HasTheSocketToItself(options) ? "true" : "false") +
         "</MultipleReceiveThreads><SocketReceiveBufferSize max=\"" +
         std::to_string(kSocketBuffer) + " B\"/>";
  // a sample that waits for an earlier one keeps the whole receive buffer that it came in; pieces
  // of a sample are kept until it is whole
  xml += "<MaxSampleSize>" + std::to_string(kLargestSample) +
         " B</MaxSampleSize><DefragReliableMaxSamples>4</DefragReliableMaxSamples></Internal>";
  xml += "<Sizing><ReceiveBufferSize>256 KiB</ReceiveBufferSize></Sizing>";
  if (real_time_receive) {
    xml += "<Threads><Thread Name=\"recv\"><Scheduling><Class>Realtime</Class><Priority>" +
           std::to_string(ReceivePriority()) + "</Priority></Scheduling></Thread></Threads>";
  }
  return xml + "</Domain>";
}

Result<Entity> CreateDomain(const DdsOptions& options, bool proves_members) {
  if (std::optional<Error> error = CheckOptions(options)) return *error;
  // no code of ours sets the environment
  if (const char* uri = std::getenv("CYCLONEDDS_URI");  // NOLINT(concurrency-mt-unsafe)
      uri != nullptr && *uri != '\0') {
    ReportDdsMessage(
        "CYCLONEDDS_URI is set; a session brings its own DDS configuration, so it is ignored");
  }
  if (options.interface != kLoopback) WatchNetworks();
  BoundWaitingInstances();
  SetCycloneStackSize();
  CycloneLogCapture log;
  const NewDomainNetworks networks(options.interface, options.domain, proves_members,
                                   AnnouncedAddress(options));
  const std::string xml = DomainXml(options, RealTimeIsPermitted());
  const dds_entity_t domain = dds_create_domain(options.domain, xml.c_str());
  if (domain > 0) return Entity(domain);

  const std::string name = "DDS domain " + std::to_string(options.domain);
  if (domain == DDS_RETCODE_PRECONDITION_NOT_MET) {
    return Error{"this program already takes part in a session on " + name + ": leave that first"};
  }
  const std::string logged = log.Take();
  if (logged.find("free participant index") != std::string::npos) {
    return Error{"no free UDP port on " + name + ": too many programs take part in it already"};
  }
  return Error{"cannot use " + name + ": " +
               (logged.empty() ? dds_strretcode(domain) : ExplainMessage(logged))};
}

}  // namespace tandem
