#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "collab/dds/cyclone/program_id.h"
#include "collab/dds/transport/dds_transport.h"
#include "collab/session/sessions_nearby.h"

namespace tandem {

/// A packet in which a participant of Tandem announces itself (RTPS, SPDP). The packet carries its
/// session's discovery tag, by which participants of other sessions drop it.
struct Announcement {
  ProgramId program{};
  AnnouncedSession session;
};

/// Reads such a packet. Returns nothing for any other packet. The packet may come from anyone, so
/// faults in it are passed over.
std::optional<Announcement> ReadAnnouncement(std::span<const std::uint8_t> packet);

/// The programs and endpoints that a packet makes DDS remember.
struct AnnouncedIn {
  bool unsound = false;  // true: announces a program as no program of Tandem announces itself, or
                         // speaks for another one
  bool program = false;  // true: announces a program, and not its end
  std::uint64_t content = 0;  // hash of what it says of the program
  double lease_s = 0;  // longest time for which DDS is to remember the program; 0: the packet
                       // gives none
  int endpoints = 0;   // number of readers, writers and topics
};
/// Returns what the packet announces. A sound packet announces only its own program, whole, with a
/// lease and with the writers that announce its endpoints. Without the lease or those writers
/// Cyclone would remember the program for longer than its lease.
AnnouncedIn WhatIsAnnounced(std::span<const std::uint8_t> packet);

/// Puts `address` (in network byte order) in the place of each IPv4 unicast address that the packet
/// announces for its program, if replaces(announced) is true.
void ReplaceAnnouncedAddresses(std::span<std::uint8_t> packet, std::uint32_t address,
                               const std::function<bool(std::uint32_t announced)>& replaces);

/// Returns the name of the session that has this tag; control characters are '?'. Nothing: the tag
/// is not Tandem's.
std::optional<std::string> SessionOfTag(const std::string& tag);

/// Keeps the programs that announced themselves lately.
class AnnouncedPrograms {
 public:
  static constexpr std::size_t kMost = 128;
  /// Each program announces itself every 1.6 s at least.
  static constexpr std::int64_t kForgetNs = 5'000'000'000;

  void Note(const Announcement& announcement, std::int64_t now_ns);
  /// Returns the sessions by name. A session that only `own` programs are in is left out.
  std::vector<AnnouncedSession> Sessions(const std::set<ProgramId>& own, std::int64_t now_ns);

 private:
  struct Program {
    Announcement announced;
    std::int64_t received_ns = 0;
  };
  std::vector<Program> programs_;
};

/// Listens where a session of these options is joined: at its multicast group. Without multicast it
/// listens at the first free discovery port of this machine, which it keeps as long as it lives.
/// Call it after joining. Where no socket can be opened, no session is heard.
std::unique_ptr<SessionsNearby> ListenForSessions(const DdsOptions& options);

}  // namespace tandem
