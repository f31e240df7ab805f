#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "collab/simulated/fault_schedule.h"
#include "collab/simulated/simulated_session.h"
#include "collab/viewer.h"

namespace tandem {

/// What must hold in every session, whatever is cut, lost or killed; looked at from outside, in
/// true time, by what is on the wire, in the simulations and in the hands.
class SessionChecker : public WireWatch {
 public:
  static constexpr double kMostForce = 12;         // N, on a device
  static constexpr double kMostForceStep = 2;      // N, from one frame to the next
  static constexpr double kMostForceAtRest = 0.5;  // N
  static constexpr double kAgreeDistance = 1e-3;   // m, of all copies when all is quiet
  static constexpr double kAgreeAngle = 0.5 * 3.141592653589793 / 180;

  SessionChecker(const FaultSchedule& schedule, const WorldModel& model, PeerId viewer);

  void OnState(PeerId from, const ObjectState& state) override;
  void OnLinks(PeerId from, const CouplingLinks& links) override;
  void OnView(PeerId from, const ViewFrame& view) override;

  /// The least one-way delay of a link from now on, ms.
  void LinkSwitched(std::size_t from, std::size_t to, const LinkConditions& link);
  /// What a hand was given in this frame, N.
  void Felt(std::size_t peer, const Vec3& force);
  /// After every frame.
  void Look(SimulatedSession& session);
  /// After the faults have stopped and time enough has passed. `of_peer`: the member of the session
  /// that a scheduled peer is, or -1.
  void LookAtEnd(SimulatedSession& session, const std::vector<int>& of_peer, const Viewer& viewer);
  /// Some time later, when the longest silence is forgotten: every link is there, and as stiff as
  /// the law says.
  void LookAtLinks(SimulatedSession& session);

  /// What did not hold, each sort once: "at 3.217 s: peer 101: …".
  const std::vector<std::string>& broken() const noexcept { return broken_; }

 private:
  struct Writer {
    std::vector<std::int64_t> stamps;  // sample_ns, rising
    std::map<ObjectId, std::uint32_t> epoch;
    std::uint32_t links_seq = 0;
    CouplingLinks links;  // newest
  };

  /// `sort`: only the first of a sort is kept.
  void Break(const std::string& sort, const std::string& what);
  std::size_t PlaceOf(PeerId id) const;
  /// The largest stiffness that the default law allows at that loop age, N/m, to one partner.
  static double LargestStiffness(double loop_s);
  void LookAtEnergy(SimulatedSession& session, std::size_t member);
  void LookAtCopies(SimulatedSession& session, const std::vector<std::size_t>& present);

  const FaultSchedule* schedule_;
  const WorldModel* model_;
  PeerId viewer_;
  std::int64_t now_ns_ = 0;
  std::map<PeerId, Writer> writers_;
  std::vector<std::vector<double>> least_delay_ms_;  // [from][to], of all time
  std::vector<std::vector<double>> most_delay_ms_;
  std::vector<Vec3> force_;               // of each hand, in its last frame
  std::vector<std::vector<Vec3>> place_;  // [member][body], a frame ago
  double energy_ = 0;  // J that all links gave since the start, less what the drag may have taken
  std::map<std::string, int> sorts_;
  std::vector<std::string> broken_;
};

}  // namespace tandem
