#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "collab/command.h"
#include "collab/coupling_law.h"
#include "collab/link_conditioner.h"
#include "collab/simulated/simulated_network.h"
#include "engine/haptics/hand_script.h"

namespace tandem {

/// A peer of a simulated session, as drawn from a seed. Peers are told by their place in
/// FaultSchedule::peers.
struct ScheduledPeer {
  PeerId id = 0;
  int object = -1;  // that it takes in hand first
  std::int64_t joins_ms = 0;
  double publish_hz = 1000;
  PeerClock clock;
  HandScript hand;  // ends at the same place for all, before the faults stop
};

/// Something that happens to a simulated session.
struct ScheduledFault {
  enum class Kind : std::uint8_t {
    kLeave,
    kKill,
    kHalt,
    kWake,
    kCut,        // from peer to other; of `other` < 0: all that it sends and hears
    kHeal,       // of such a cut
    kCondition,  // of what peer sends to other
    kClockStep,  // forward: a monotonic clock does not go back
    kCommand
  };
  std::int64_t t_ms = 0;
  Kind kind = Kind::kKill;
  int peer = 0;
  int other = -1;
  bool both_ways = false;  // of a cut, a heal
  LinkConditions conditions;
  std::int64_t step_ns = 0;
  Command command;
};

/// What a seed stands for: peers, links and faults, and when all faults are over.
struct FaultSchedule {
  std::uint64_t seed = 0;
  std::vector<ScheduledPeer> peers;
  std::vector<std::vector<double>> delay_ms;       // of the link [from][to], for good
  std::vector<std::vector<LinkConditions>> links;  // [from][to], until the faults stop
  std::vector<ScheduledFault> faults;              // by time
  std::int64_t faults_end_ms = 0;
  // of all couplings; "constant" has the energy gates alone to keep still
  std::string law = DefaultLaw()->name();

  double LongestRoundTripMs() const;
  /// The longest way that anything is under way on, while there are faults too, ms.
  double LongestWayMs() const;
};

/// Three to five peers; joins, leaves, kills, pauses, cuts, heals, delay of 0 to 2 s, loss of 0 to
/// 30 %, grabs, releases and hand-overs, clock steps and drift. At least two peers stay to the end.
FaultSchedule DrawSchedule(std::uint64_t seed);

/// How often each sort of thing happens in a session: "kills", "late joins".
using Tally = std::map<std::string, std::uint64_t>;

/// Of what is scheduled.
Tally CountOf(const FaultSchedule& schedule);

/// A line for each peer and fault, by time, for a person to follow.
std::vector<std::string> Describe(const FaultSchedule& schedule);

/// The line of one fault.
std::string Describe(const FaultSchedule& schedule, const ScheduledFault& fault);

}  // namespace tandem
