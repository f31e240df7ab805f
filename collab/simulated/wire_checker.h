#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "collab/simulated/breakages.h"
#include "collab/simulated/fault_schedule.h"
#include "collab/simulated/simulated_network.h"

namespace tandem {

/// The largest stiffness that a coupling law allows to one partner at a loop age, N/m, from the
/// formulas of docs/decisions/0005, 0017 and 0050, worked out apart from the product's.
double LargestStiffness(const std::string& law, double loop_s);

/// What must hold of all that peers put on the wire: sound numbers, own names, stamps and epochs
/// that only grow, echoes of what was sent, no link stiffer than its loop allows, nothing at all
/// from a viewer.
class WireChecker : public WireWatch {
 public:
  WireChecker(const FaultSchedule& schedule, PeerId viewer, Breakages& breakages);

  void OnState(PeerId from, const ObjectState& state) override;
  void OnLinks(PeerId from, const CouplingLinks& links) override;
  void OnView(PeerId from, const ViewFrame& view) override;
  void OnPeerInfo(PeerId from, const PeerInfo& info) override;
  void OnEvent(PeerId from, const Event& event) override;

  /// Whose stamps are not looked at.
  void SetHostile(PeerId peer) { hostile_ = peer; }
  /// Of what `from` sends to `to`, from now on.
  void LinkSwitched(std::size_t from, std::size_t to, const LinkConditions& link);
  /// What waits for its time at a peer whose clock is put forward comes so much sooner.
  void ClockStepped(std::size_t peer, double step_ms);
  /// The longest that the loop between two has been, s.
  double LongestLoop(std::size_t a, std::size_t b) const;
  /// What a peer sent last.
  const CouplingLinks& NewestLinks(PeerId from) { return writers_[from].links; }
  /// Place of a peer in the schedule; beyond its end: there is none.
  std::size_t PlaceOf(PeerId id) const;

 private:
  struct Writer {
    std::vector<std::int64_t> stamps;  // sample_ns, rising
    std::map<ObjectId, std::uint32_t> epoch;
    std::uint32_t beat = 0;
    std::uint32_t event_seq = 0;
    CouplingLinks links;  // newest
  };

  void Own(PeerId from, PeerId says);

  const FaultSchedule* schedule_;
  PeerId viewer_;
  PeerId hostile_ = 0;
  Breakages* breakages_;
  std::map<PeerId, Writer> writers_;
  std::vector<std::vector<double>> least_delay_ms_;  // [from][to], of all time
  std::vector<std::vector<double>> most_delay_ms_;
};

}  // namespace tandem
