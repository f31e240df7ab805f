#include <algorithm>
#include <array>
#include <set>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/networks/usable_networks.h"
#include "collab/dds/transport/announcements.h"
#include "collab/dds/transport/domain.h"
#include "engine/realtime/clock.h"

// Hears the announcements of programs on the network, and keeps the sessions that they are in.

namespace tandem {
namespace {

constexpr const char* kGroup = "239.255.0.1";
constexpr int kMostPackets = 256;  // read in one call

/// A non-blocking UDP socket.
class ListeningSocket {
 public:
  ListeningSocket() : descriptor_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {}
  ~ListeningSocket() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  ListeningSocket(const ListeningSocket&) = delete;
  ListeningSocket& operator=(const ListeningSocket&) = delete;

  bool Bind(in_addr_t address, std::uint32_t port) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = address;
    at.sin_port = htons(static_cast<std::uint16_t>(port));
    return bind(descriptor_, reinterpret_cast<sockaddr*>(&at), sizeof at) == 0;
  }
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

/// Joins the group on the interface of that name, or on all interfaces.
void JoinGroup(int descriptor, const std::string& interface) {
  for (const NetworkAddress& one : UsableNetworks()) {
    if (!interface.empty() && interface != one.name) continue;
    ip_mreqn request{};
    inet_pton(AF_INET, kGroup, &request.imr_multiaddr);
    request.imr_ifindex = static_cast<int>(one.interface);
    // fails where it is a member already
    setsockopt(descriptor, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request);
  }
}

/// Returns this process's own participants in a domain.
std::set<ProgramId> OwnPrograms(std::uint32_t domain) {
  std::set<ProgramId> own;
  std::array<dds_entity_t, 16> participants{};
  const dds_return_t found =
      dds_lookup_participant(domain, participants.data(), participants.size());
  for (dds_return_t i = 0; i < std::min<dds_return_t>(found, 16); ++i) {
    dds_guid_t guid{};
    if (dds_get_guid(participants[static_cast<std::size_t>(i)], &guid) != DDS_RETCODE_OK) continue;
    ProgramId program{};
    std::copy_n(guid.v, program.size(), program.begin());
    own.insert(program);
  }
  return own;
}

class AnnouncedSessions final : public SessionsNearby {
 public:
  explicit AnnouncedSessions(const DdsOptions& options)
      : domain_(options.domain), interface_(options.interface) {
    if (options.interface != "lo" && options.peers.empty()) {
      const int yes = 1;
      setsockopt(multicast_.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
      // else packets of the group come from all interfaces on which any program has joined it
      const int no = 0;
      setsockopt(multicast_.get(), IPPROTO_IP, IP_MULTICAST_ALL, &no, sizeof no);
      in_addr group{};
      inet_pton(AF_INET, kGroup, &group);
      if (multicast_.Bind(group.s_addr, 7400 + 250 * domain_)) {
        JoinGroup(multicast_.get(), interface_);
        joins_ = true;
      }
      return;
    }
    // without multicast each program announces itself at every port that a program may have
    for (std::uint32_t i = 0; i <= kLastProgramIndex; ++i) {
      if (BindToInterface(unicast_.get(), interface_,
                          static_cast<std::uint16_t>(DiscoveryPort(domain_, i)))) {
        return;
      }
    }
  }

  std::vector<AnnouncedSession> Heard() override {
    own_.merge(OwnPrograms(domain_));
    // networks come and go
    if (joins_) JoinGroup(multicast_.get(), interface_);
    const std::int64_t now_ns = MonotonicNowNs();
    for (const ListeningSocket* socket : {&multicast_, &unicast_}) Take(socket->get(), now_ns);
    return programs_.Sessions(own_, now_ns);
  }

 private:
  void Take(int descriptor, std::int64_t now_ns) {
    std::array<std::uint8_t, 65536> packet;
    for (int i = 0; i < kMostPackets; ++i) {
      const ssize_t size = recv(descriptor, packet.data(), packet.size(), MSG_DONTWAIT);
      if (size < 0) return;
      const auto announcement = ReadAnnouncement({packet.data(), static_cast<std::size_t>(size)});
      if (announcement) programs_.Note(*announcement, now_ns);
    }
  }

  const std::uint32_t domain_;
  const std::string interface_;
  bool joins_ = false;
  ListeningSocket multicast_;
  ListeningSocket unicast_;
  std::set<ProgramId> own_;
  AnnouncedPrograms programs_;
};

}  // namespace

void AnnouncedPrograms::Note(const Announcement& announcement, std::int64_t now_ns) {
  const auto known = std::find_if(programs_.begin(), programs_.end(), [&](const Program& one) {
    return one.announced.program == announcement.program &&
           one.announced.session == announcement.session;
  });
  if (known != programs_.end()) {
    known->received_ns = now_ns;
  } else if (programs_.size() < kMost) {
    programs_.push_back({announcement, now_ns});
  }
}

std::vector<AnnouncedSession> AnnouncedPrograms::Sessions(const std::set<ProgramId>& own,
                                                          std::int64_t now_ns) {
  std::erase_if(programs_, [now_ns](const Program& program) {
    return now_ns - program.received_ns > kForgetNs;
  });
  std::set<AnnouncedSession> sessions;
  for (const Program& program : programs_) {
    if (!own.contains(program.announced.program)) sessions.insert(program.announced.session);
  }
  return {sessions.begin(), sessions.end()};
}

std::unique_ptr<SessionsNearby> ListenForSessions(const DdsOptions& options) {
  return std::make_unique<AnnouncedSessions>(options);
}

}  // namespace tandem
