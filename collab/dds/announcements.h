#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "collab/dds/dds_transport.h"
#include "collab/sessions_nearby.h"

namespace tandem {

using ProgramId = std::array<std::uint8_t, 12>;  // prefix of a participant's GUID

/// A packet in which a participant of ours announces itself (RTPS, SPDP): it has its session's
/// discovery tag, by which the participants of other sessions drop it.
struct Announcement {
  ProgramId program{};
  AnnouncedSession session;
};

/// Nothing: the packet is no such announcement. It may be anybody's: whatever is wrong in it is
/// passed over.
std::optional<Announcement> ReadAnnouncement(std::span<const std::uint8_t> packet);

/// What a packet makes DDS remember.
struct AnnouncedIn {
  bool unsound = false;  // announces a program as none of ours announces itself
  double lease_s = 0;    // for which the program is to be remembered, the longest; 0: none is said
  int endpoints = 0;     // readers, writers and topics
};
/// A program announces itself alone, whole, with a lease and with the writers that announce its
/// endpoints. Cyclone would remember one without either of the two for longer than its lease.
AnnouncedIn WhatIsAnnounced(std::span<const std::uint8_t> packet);

/// The name of the session that has this tag; control characters are '?'. Nothing: it is not ours.
std::optional<std::string> SessionOfTag(const std::string& tag);

/// The programs that announced themselves lately.
class AnnouncedPrograms {
 public:
  static constexpr std::size_t kMost = 128;
  /// Each announces itself every 1.6 s at least.
  static constexpr std::int64_t kForgetNs = 5'000'000'000;

  void Note(const Announcement& announcement, std::int64_t now_ns);
  /// Their sessions by name, without those of `own` programs alone.
  std::vector<AnnouncedSession> Sessions(const std::set<ProgramId>& own, std::int64_t now_ns);

 private:
  struct Program {
    Announcement announced;
    std::int64_t heard_ns = 0;
  };
  std::vector<Program> programs_;
};

/// Listens where a session of these options is joined: at its multicast group, and without
/// multicast at the first free discovery port of this machine, which it has as long as it lives.
/// To be made after joining. What cannot be listened to is not heard of.
std::unique_ptr<SessionsNearby> ListenForSessions(const DdsOptions& options);

}  // namespace tandem
