#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "collab/simulated/checkers/violations.h"
#include "collab/simulated/network/fault_schedule.h"
#include "collab/simulated/network/simulated_network.h"

namespace tandem {

/// Returns the largest stiffness that a coupling law allows to one link at a loop age, N/m. It
/// uses the formulas of docs/decisions/0005, 0017 and 0050, coded independently of the product.
double LargestStiffness(const std::string& law, double loop_s);

/// Judges all that peers put on the wire. Numbers are sound, and a peer uses its own name. Stamps
/// and epochs only grow, and echoes are of samples that were sent. No link is stiffer than its loop
/// allows, and a viewer sends nothing.
class WireChecker : public WireWatch {
 public:
  WireChecker(const FaultSchedule& schedule, PeerId viewer, Violations& violations);

  void OnState(PeerId from, const ObjectState& state) override;
  void OnLinks(PeerId from, const CouplingLinks& links) override;
  void OnView(PeerId from, const ViewFrame& view) override;
  void OnPeerInfo(PeerId from, const PeerInfo& info) override;
  void OnEvent(PeerId from, const Event& event) override;

  /// Names the hostile peer, whose stamps are not judged.
  void SetHostile(PeerId peer) { hostile_ = peer; }
  /// Notes new conditions of the link from `from` to `to`.
  void LinkSwitched(std::size_t from, std::size_t to, const LinkConditions& link);
  /// Notes a clock step. If a peer's clock is put forward, messages that wait for their time there
  /// come so much sooner.
  void ClockStepped(std::size_t peer, double step_ms);
  /// Returns the longest that the loop between two peers has been, s.
  double LongestLoop(std::size_t a, std::size_t b) const;
  /// Returns the links that a peer sent last.
  const CouplingLinks& NewestLinks(PeerId from) { return writers_[from].links; }
  /// Returns a peer's index in the schedule; the number of peers: there is no such peer.
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
  Violations* violations_;
  std::map<PeerId, Writer> writers_;
  std::vector<std::vector<double>> least_delay_ms_;  // [from][to], over all time
  std::vector<std::vector<double>> most_delay_ms_;
};

}  // namespace tandem
