#pragma once

#include "collab/simulated/checkers/authority_checker.h"
#include "collab/simulated/checkers/energy_checker.h"
#include "collab/simulated/checkers/hand_checker.h"
#include "collab/simulated/checkers/hostile_member_checker.h"
#include "collab/simulated/checkers/link_force_checker.h"
#include "collab/simulated/checkers/motion_checker.h"
#include "collab/simulated/checkers/rest_checker.h"
#include "collab/simulated/checkers/wire_checker.h"

namespace tandem {

/// Judges every session, whatever is cut, lost or killed. It looks from outside, in true time, at
/// the wire, the simulations and the hands. Each part has its own checker.
class SessionChecker : public WireWatch {
 public:
  /// Bounds for hands that are not scripted.
  struct Bounds {
    bool fast = false;                                 // as for MotionChecker
    double short_loop = LinkForceChecker::kShortLoop;  // s
    double kept = EnergyChecker::kMostKept;            // J
  };
  SessionChecker(const FaultSchedule& schedule, const WorldModel& model, PeerId viewer)
      : SessionChecker(schedule, model, viewer, Bounds()) {}
  SessionChecker(const FaultSchedule& schedule, const WorldModel& model, PeerId viewer,
                 const Bounds& bounds)
      : schedule_(&schedule),
        wire_(schedule, viewer, violations_),
        authority_(model, violations_),
        keep_(model, violations_),
        motion_(model, violations_, bounds.fast),
        energy_(model, violations_, bounds.kept),
        pulls_(violations_, bounds.short_loop),
        hands_(schedule.peers.size(), violations_),
        rest_(schedule, model, violations_) {}

  /// Names the hostile peer. Its messages are not judged, only their effects on the others.
  void SetHostile(PeerId peer) {
    hostile_ = peer;
    wire_.SetHostile(peer);
    authority_.SetHostile(peer);
    keep_.SetHostile(peer);
    motion_.SetHostile(peer);
  }
  void Wished(PeerId peer, std::int64_t now_ns) { keep_.Wished(peer, now_ns); }

  void OnState(PeerId from, const ObjectState& state) override {
    if (from == hostile_) return;
    wire_.OnState(from, state);
    authority_.OnState(from, state);
  }
  void OnLinks(PeerId from, const CouplingLinks& links) override { wire_.OnLinks(from, links); }
  void OnView(PeerId from, const ViewFrame& view) override { wire_.OnView(from, view); }
  void OnPeerInfo(PeerId from, const PeerInfo& info) override {
    if (from != hostile_) wire_.OnPeerInfo(from, info);
  }
  void OnEvent(PeerId from, const Event& event) override {
    if (from == hostile_) return motion_.OnHostileEvent(event);
    wire_.OnEvent(from, event);
    ++events_[static_cast<std::size_t>(event.kind)];
  }

  /// Notes new conditions of the link from `from` to `to`.
  void LinkSwitched(std::size_t from, std::size_t to, const LinkConditions& link) {
    wire_.LinkSwitched(from, to, link);
  }
  void ClockStepped(std::size_t peer, double step_ms) { wire_.ClockStepped(peer, step_ms); }
  /// Judges what the hand of a scheduled peer gets in this frame.
  void RenderedForces(std::size_t peer, const Wrench& F_D_W) {
    hands_.RenderedForces(peer, schedule_->peers[peer].id, F_D_W);
  }
  /// Call it before every frame.
  void SetTime(std::int64_t now_ns) noexcept { violations_.SetTime(now_ns); }
  /// Judges a frame; call it after every frame.
  void Check(SimulatedSession& session) {
    authority_.Check(session);
    keep_.Check(session);
    motion_.Check(session);
    energy_.Check(session);
    pulls_.Check(session);
  }
  /// Judges the end, when the faults are over, the hands rest and enough time has passed. `member`
  /// is the number in the session of each scheduled peer; -1: it never came.
  void CheckEnd(SimulatedSession& session, const std::vector<int>& member, const Viewer& viewer) {
    constexpr std::int64_t kBeginNs = 1'000'000'000;  // true time of the first frame
    authority_.CheckEnd(session, kBeginNs + 1'000'000 * schedule_->faults_end_ms);
    pulls_.CheckEnd();
    rest_.Check(session, member, hands_, viewer);
  }
  void NeverAtRest() { violations_.Add("hands do not come to rest", 0); }
  /// Judges the links; call it later, when the longest silence is forgotten.
  void CheckLinks(SimulatedSession& session) { rest_.CheckLinks(session, wire_); }

  const Violations& violations() const noexcept { return violations_; }
  /// Returns the collection for checkers outside this one.
  Violations& violations() noexcept { return violations_; }
  /// Returns how many events of a kind have been on the wire.
  std::uint64_t events(EventKind kind) const { return events_[static_cast<std::size_t>(kind)]; }

 private:
  const FaultSchedule* schedule_;
  Violations violations_;
  WireChecker wire_;
  AuthorityChecker authority_;
  HostileMemberChecker keep_;
  PeerId hostile_ = 0;
  MotionChecker motion_;
  EnergyChecker energy_;
  LinkForceChecker pulls_;
  HandChecker hands_;
  RestChecker rest_;
  std::array<std::uint64_t, 5> events_{};
};

}  // namespace tandem
