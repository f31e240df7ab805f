#include "collab/dds/domain.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <set>
#include <thread>

#include <ifaddrs.h>
#include <net/if.h>
#include <pthread.h>

#include "collab/dds/cyclone_log.h"

namespace tandem {
namespace {

constexpr std::size_t kMaxSessionName = 128;
constexpr std::uint32_t kMaxDomain = 230;  // its ports end at 65159
constexpr int kReceivePriority =
    40;  // above the haptic thread's: it is short, and carries what that waits for
constexpr const char* kLoopback = "lo";

bool IsPlain(char c) {  // in any locale
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
         c == '_' || c == '-';
}

std::string EscapeXml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

// Whether a thread of this process may have the receive thread's priority: found by trying on one.
bool RealTimeIsPermitted() {
  bool permitted = false;
  std::thread([&] {
    sched_param parameters{};
    parameters.sched_priority = kReceivePriority;
    permitted = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
  }).join();
  return permitted;
}

// Why `name` is no interface to use, or nothing.
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

std::optional<Error> CheckOptions(const DdsOptions& options) {
  if (options.session.empty()) return Error{"a session needs a name"};
  if (options.session.size() > kMaxSessionName) {
    return Error{"the session's name is longer than " + std::to_string(kMaxSessionName) + " bytes"};
  }
  if (options.domain > kMaxDomain) {
    return Error{"there is no DDS domain " + std::to_string(options.domain) +
                 ": they go from 0 to " + std::to_string(kMaxDomain)};
  }
  if (!options.interface.empty()) return CheckInterface(options.interface);
  return std::nullopt;
}

}  // namespace

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
  std::string xml = "<Domain Id=\"any\">";
  if (!options.interface.empty()) {
    xml += "<General><Interfaces><NetworkInterface name=\"" + EscapeXml(options.interface) +
           "\"/></Interfaces><AllowMulticast>" + (loopback ? "false" : "true") +
           "</AllowMulticast></General>";
  }
  xml += "<Discovery><Tag>" + DiscoveryTag(options.session) +
         "</Tag>"
         "<ParticipantIndex>auto</ParticipantIndex>"
         "<MaxAutoParticipantIndex>60</MaxAutoParticipantIndex>"
         "<LeaseDuration>2 s</LeaseDuration>";
  if (loopback) xml += "<Peers><Peer address=\"127.0.0.1\"/></Peers>";
  xml += "</Discovery><Internal><MultipleReceiveThreads>false</MultipleReceiveThreads></Internal>";
  if (real_time_receive) {
    xml += "<Threads><Thread Name=\"recv\"><Scheduling><Class>Realtime</Class><Priority>" +
           std::to_string(kReceivePriority) + "</Priority></Scheduling></Thread></Threads>";
  }
  return xml + "</Domain>";
}

Result<Entity> CreateDomain(const DdsOptions& options) {
  if (std::optional<Error> error = CheckOptions(options)) return *error;
  // nothing of ours sets the environment
  if (const char* uri = std::getenv("CYCLONEDDS_URI");  // NOLINT(concurrency-mt-unsafe)
      uri != nullptr && *uri != '\0') {
    std::fprintf(
        stderr,
        "CYCLONEDDS_URI is set; a session brings its own DDS configuration, so it is ignored\n");
  }
  CycloneLogCapture log;
  const std::string xml = DomainXml(options, RealTimeIsPermitted());
  const dds_entity_t domain = dds_create_domain(options.domain, xml.c_str());
  if (domain > 0) return Entity(domain);

  const std::string name = "DDS domain " + std::to_string(options.domain);
  if (domain == DDS_RETCODE_PRECONDITION_NOT_MET) {
    return Error{"this program already takes part in a session on " + name + ": leave that first"};
  }
  const std::string said = log.Take();
  if (said.find("free participant index") != std::string::npos) {
    return Error{"no free UDP port on " + name + ": too many programs take part in it already"};
  }
  return Error{"cannot use " + name + ": " + (said.empty() ? dds_strretcode(domain) : said)};
}

}  // namespace tandem
