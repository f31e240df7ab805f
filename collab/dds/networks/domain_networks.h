#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <sys/socket.h>

#include "collab/dds/networks/announced_sources.h"
#include "collab/dds/networks/network_table.h"

namespace tandem {

/// How a packet came.
struct Arrival {
  std::uint32_t from = 0;  // address of the sender
  std::uint32_t at = 0;    // this machine's address on the interface
  unsigned interface = 0;  // the kernel's number of the interface
  bool to_group = false;   // sent to a multicast group
};

/// The networks that one DDS domain is on, and the domain's sockets.
///
/// DDS sees a single network that leads everywhere. This class stands between DDS and the kernel:
/// what DDS sends to a group goes out on every usable network, and what it sends to an address goes
/// the way of the kernel's route. Networks may come and go meanwhile. A domain on loopback is on
/// nothing else, and a domain on one interface is on that interface and on loopback.
///
/// Cyclone's threads send and receive; the thread that watches networks calls OnChange() and Cut().
class DomainNetworks {
 public:
  enum class Reach : std::uint8_t { kLoopback, kInterface, kAll };

  /// `interface`: the name of the only interface; "lo": loopback alone; empty: all networks.
  /// `domain`: the number of the DDS domain. `proves_members`: its members prove their keys, and
  /// the transport says which ones have.
  explicit DomainNetworks(const std::string& interface, std::uint32_t domain = 0,
                          bool proves_members = false);

  std::uint32_t domain() const noexcept { return domain_; }
  Reach reach() const noexcept { return reach_; }
  /// Returns whether a packet that came that way may be heard.
  bool Hears(const Arrival& arrival) const noexcept;
  /// Returns whether the domain takes no packets and sends none at this time.
  bool IsCut(std::int64_t now_ns) const noexcept { return now_ns < cut_until_ns_.load(); }

  /// Takes a socket that DDS is about to bind, and changes the address to bind it to. Returns false
  /// if the kernel refuses what the bound needs.
  bool Bind(int socket, std::uint32_t& address);
  /// Makes a socket a member of a group on every network of the domain.
  void Join(int socket, std::uint32_t group);
  /// Forgets a socket. Returns whether it was the last.
  bool Release(int socket);

  /// Sends a packet of DDS. Returns its bytes, or -1 if no network takes it.
  ssize_t Send(int socket, const msghdr& packet, int flags);
  /// Notes that a packet was heard.
  void Note(const Arrival& arrival, std::int64_t now_ns) noexcept;

  /// Sets which programs are met, the own one among them; see AnnouncedSources. `programs` is
  /// sorted and names each once.
  void SetMet(std::vector<ProgramId> programs);
  bool proves_members() const noexcept { return sources_.has_value(); }
  /// Returns whether DDS may see a packet of the program, which announces it from that source; no
  /// source: it announces nothing. Where members do not prove their keys, it may see all.
  bool Lets(std::span<const std::uint8_t> program, const std::optional<AnnouncedSource>& source,
            std::int64_t now_ns) noexcept;

  /// Joins networks that have come. Returns whether an address has gone by which others reach this
  /// domain.
  bool OnChange(const NetworkTable& before, const NetworkTable& now, std::int64_t now_ns);
  void Cut(std::int64_t until_ns) noexcept { cut_until_ns_.store(until_ns); }

 private:
  struct Membership {
    int socket = -1;
    std::uint32_t group = 0;
  };
  // An address of this machine at which packets come.
  struct Heard {
    std::atomic<std::uint32_t> address{0};
    std::atomic<unsigned> interface { 0 };
    std::atomic<std::int64_t> unicast_ns{0};
    std::atomic<std::int64_t> any_ns{0};
  };

  bool Uses(const NetworkTable::Row& row) const noexcept;
  bool WasHeardOn(unsigned interface, std::int64_t now_ns) const noexcept;
  ssize_t SendToGroup(int socket, const msghdr& packet, int flags, std::uint16_t port);
  ssize_t SendBy(const NetworkTable::Row* row, int socket, const msghdr& packet, int flags) const;
  void JoinAll(const Membership& membership, const NetworkTable& table) const;

  const Reach reach_;
  const std::uint32_t domain_;
  std::array<char, 16> name_{};  // name of the only interface
  std::atomic<std::int64_t> cut_until_ns_ = 0;
  std::atomic<std::uint16_t> discovery_port_ = 0;  // port of the group of discovery; 0: none
  std::array<Heard, NetworkTable::kMost> heard_;
  std::mutex mutex_;
  std::vector<int> sockets_;
  std::vector<Membership> memberships_;
  std::mutex sources_mutex_;
  std::optional<AnnouncedSources> sources_;  // where members prove their keys
};

/// While it lives, the sockets that DDS makes on this thread are those of one domain.
class NewDomainNetworks {
 public:
  /// `announced`: the address that the domain announces; others answer where its packets come from.
  NewDomainNetworks(const std::string& interface, std::uint32_t domain, bool proves_members,
                    std::uint32_t announced);
  ~NewDomainNetworks();
  NewDomainNetworks(const NewDomainNetworks&) = delete;
  NewDomainNetworks& operator=(const NewDomainNetworks&) = delete;
};

/// Returns the networks of the domain that a socket belongs to; null: of no domain of Tandem's.
DomainNetworks* NetworksOfSocket(int socket) noexcept;

}  // namespace tandem
