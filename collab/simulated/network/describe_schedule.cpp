#include <cstdio>

#include "collab/simulated/network/fault_schedule.h"

namespace tandem {

namespace {

std::string NameOf(const FaultSchedule& schedule, int peer) {
  return std::to_string(schedule.peers[static_cast<std::size_t>(peer)].id);
}

std::string AtSecond(std::int64_t ms) {
  char text[32];
  std::snprintf(text, sizeof text, "%6.3f s: peer ", 1e-3 * static_cast<double>(ms));
  return text;
}

std::string Describe(const LinkConditions& link) {
  char text[200];
  std::snprintf(text, sizeof text,
                "%.0f ms, jitter %.0f, swing %.0f, loss %.0f %%, bursts %.1f %%, out of order "
                "%.0f %%, twice %.0f %%",
                link.delay_ms, link.jitter_ms, link.swing_ms, 100 * link.loss,
                100 * link.burst_enter, 100 * link.reorder, 100 * link.duplicate);
  return text;
}

std::string Describe(const Command& command) {
  switch (command.kind) {
    case Command::Kind::kGrab:
      return "grabs object " + std::to_string(command.object);
    case Command::Kind::kRelease:
      return "lets go";
    case Command::Kind::kGive:
      return "gives what it holds to peer " + std::to_string(command.to);
    case Command::Kind::kHeal:
      return "asks to heal";
    case Command::Kind::kLayer:
      return "asks for force layer " + std::to_string(command.layer);
    case Command::Kind::kDisplace:
      return "displaces its points by " + std::to_string(1e3 * command.metres) + " mm";
    case Command::Kind::kStop:
      return "stops its device";
    case Command::Kind::kResume:
      return "lets its device go on";
    case Command::Kind::kScale:
      return "scales its device by " + std::to_string(command.metres);
  }
  return {};
}

const char* SortOf(const ScheduledFault& fault) {
  using Kind = ScheduledFault::Kind;
  switch (fault.kind) {
    case Kind::kLeave:
      return "leaves";
    case Kind::kKill:
      return "kills";
    case Kind::kHalt:
      return "pauses";
    case Kind::kCut:
      return fault.other < 0 ? "cuts from all" : fault.both_ways ? "cuts" : "one-way cuts";
    case Kind::kCondition:
      return "other links";
    case Kind::kClockStep:
      return "clock steps";
    case Kind::kCommand:
      return fault.command.kind == Command::Kind::kGrab      ? "wishes to grab"
             : fault.command.kind == Command::Kind::kRelease ? "wishes to let go"
                                                             : "wishes to give";
    case Kind::kWake:
    case Kind::kHeal:
      return nullptr;
  }
  return nullptr;
}

}  // namespace

Tally CountOf(const FaultSchedule& schedule) {
  constexpr std::int64_t kLateMs = 300;
  Tally tally;
  for (const ScheduledPeer& peer : schedule.peers) {
    ++tally["peers"];
    if (peer.joins_ms > kLateMs) ++tally["late joins"];
  }
  for (const auto& row : schedule.links) {
    for (const LinkConditions& link : row) {
      if (link.loss > 0) ++tally["links with loss"];
      if (link.burst_enter > 0) ++tally["links with bursts"];
      if (link.reorder > 0) ++tally["links out of order"];
      if (link.duplicate > 0) ++tally["links with copies"];
      if (link.delay_ms > 250) ++tally["links beyond 250 ms"];
    }
  }
  for (const ScheduledFault& fault : schedule.faults) {
    if (const char* const sort = SortOf(fault)) ++tally[sort];
  }
  return tally;
}

std::string Describe(const FaultSchedule& schedule, const ScheduledFault& fault) {
  using Kind = ScheduledFault::Kind;
  const std::string whom = fault.other < 0 ? "all" : "peer " + NameOf(schedule, fault.other);
  const std::string what = AtSecond(fault.t_ms) + NameOf(schedule, fault.peer) + " ";
  switch (fault.kind) {
    case Kind::kLeave:
      return what + "leaves";
    case Kind::kKill:
      return what + "is killed";
    case Kind::kHalt:
      return what + "is stopped";
    case Kind::kWake:
      return what + "goes on";
    case Kind::kCut:
      return what + (fault.both_ways ? "is cut from " : "is not heard any more by ") + whom;
    case Kind::kHeal:
      return what + (fault.both_ways ? "is joined again to " : "is heard again by ") + whom;
    case Kind::kCondition:
      return what + "reaches " + whom + " by another way: " + Describe(fault.conditions);
    case Kind::kClockStep:
      return what + "has its clock put forward by " + std::to_string(fault.step_ns / 1'000'000) +
             " ms";
    case Kind::kCommand:
      return what + Describe(fault.command);
  }
  return what;
}

std::vector<std::string> Describe(const FaultSchedule& schedule) {
  std::vector<std::string> lines;
  for (const ScheduledPeer& peer : schedule.peers) {
    char text[160];
    std::snprintf(text, sizeof text, "%llu joins, object %d, %.0f Hz, clock %+.0f ppm",
                  static_cast<unsigned long long>(peer.id), peer.object, peer.publish_hz,
                  peer.clock.drift_ppm);
    lines.push_back(AtSecond(peer.joins_ms) + text);
  }
  for (std::size_t from = 0; from < schedule.peers.size(); ++from) {
    for (std::size_t to = 0; to < schedule.peers.size(); ++to) {
      if (from == to) continue;
      lines.push_back("from peer " + std::to_string(schedule.peers[from].id) + " to " +
                      std::to_string(schedule.peers[to].id) + ": " +
                      Describe(schedule.links[from][to]));
    }
  }
  for (const ScheduledFault& fault : schedule.faults) lines.push_back(Describe(schedule, fault));
  char text[160];
  std::snprintf(text, sizeof text, "law %s, longest round trip %.0f ms; faults end at %.3f s",
                schedule.law.c_str(), schedule.LongestRoundTripMs(),
                1e-3 * static_cast<double>(schedule.faults_end_ms));
  lines.emplace_back(text);
  return lines;
}

}  // namespace tandem
