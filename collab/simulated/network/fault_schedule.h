#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "collab/coupling/coupling_law.h"
#include "collab/receive/link_conditioner.h"
#include "collab/session/command.h"
#include "collab/simulated/network/simulated_network.h"
#include "engine/haptics/hand_script.h"

namespace tandem {

/// A peer of a simulated session, as drawn from a seed. Faults name a peer by its index in
/// FaultSchedule::peers.
struct ScheduledPeer {
  PeerId id = 0;
  int object = -1;  // object that it takes in hand first
  std::int64_t joins_ms = 0;
  double publish_hz = 1000;
  PeerClock clock;
  HandScript hand;  // ends at the same place for all, before the faults stop
};

/// An event in a simulated session.
struct ScheduledFault {
  enum class Kind : std::uint8_t {
    kLeave,
    kKill,
    kHalt,
    kWake,
    kCut,        // from peer to other; `other` < 0: all that the peer sends and receives
    kHeal,       // end of such a cut
    kCondition,  // new link conditions from peer to other
    kClockStep,  // forward: a monotonic clock does not go back
    kCommand
  };
  std::int64_t t_ms = 0;
  Kind kind = Kind::kKill;
  int peer = 0;
  int other = -1;
  bool both_ways = false;  // for kCut and kHeal
  LinkConditions conditions;
  std::int64_t step_ns = 0;
  Command command;
};

/// The session that a seed stands for: peers, links and faults, and the time when all faults are
/// over.
struct FaultSchedule {
  std::uint64_t seed = 0;
  std::vector<ScheduledPeer> peers;
  std::vector<std::vector<double>> delay_ms;       // [from][to], also after the faults stop
  std::vector<std::vector<LinkConditions>> links;  // [from][to], until the faults stop
  std::vector<ScheduledFault> faults;              // sorted by time
  std::int64_t faults_end_ms = 0;
  // for all couplings; with "constant" only the energy gates keep the bodies still
  std::string law = DefaultLaw()->name();

  double LongestRoundTripMs() const;
  /// Returns the longest delay of any message, also while there are faults, ms.
  double LongestWayMs() const;
};

/// Draws a session of three to five peers. It has joins, leaves, kills, pauses, cuts and their
/// ends, delay of 0 to 2 s, loss of 0 to 30 %, grabs, releases and hand-overs, clock steps and
/// drift. At least two peers stay to the end.
FaultSchedule DrawSchedule(std::uint64_t seed);

/// Number of events of each sort in a session: "kills", "late joins".
using Tally = std::map<std::string, std::uint64_t>;

/// Counts the scheduled events.
Tally CountOf(const FaultSchedule& schedule);

/// Returns a line for each peer and fault, by time, for a person to follow.
std::vector<std::string> Describe(const FaultSchedule& schedule);

/// Returns the line of one fault.
std::string Describe(const FaultSchedule& schedule, const ScheduledFault& fault);

}  // namespace tandem
